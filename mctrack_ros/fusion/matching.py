"""All pictures of a tick against the tracks: assignment, update, what else is learned."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_1D, INTS_1D, compiled
from mctrack_ros.fusion.account import Account
from mctrack_ros.fusion.covering import COSTS, CoveringAssociation
from mctrack_ros.fusion.gating import distances
from mctrack_ros.fusion.joint import JointAssociation
from mctrack_ros.fusion.looks import Looks
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.recognition import look_at
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.kalman import position_matrix, update

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Templates = NDArray[np.float32]
TEMPLATES = types.Array(types.f4, 2, 'C', readonly=True)

VELOCITY = np.eye(4)[2:]

ASSOCIATIONS = dict.fromkeys(COSTS, CoveringAssociation)
"""By method, what associates the pictures of a tick; that of all others is `JointAssociation`."""

GROUP_INFLATION = 100.0
"""How much less a merged detection says about one of its members, picture after picture: factor
of its covariance. He keeps his place in the group, and is not drawn to its middle."""

COMPANY_DENSITY = 0.5
"""How loosely a hidden member moves with those who are seen: power spectral density of what his
velocity differs from theirs by, m²/s."""


def match(
    table: TrackTable, looks: Looks, config: FusionConfig, account: Account | None = None
) -> Indices:
    """
    Associate the pictures of a tick with the tracks and update these.

    Parameters
    ----------
    table : TrackTable
        The tracks, predicted to the tick's stamp; changed in place.
    looks : Looks
        The pictures.
    config : FusionConfig
        Parameters.
    account : Account, optional
        Takes down why.

    Returns
    -------
    (k,) array
        The single detections that no track took, and that may start one.

    """
    kind = ASSOCIATIONS.get(config.association.method, JointAssociation)
    association = kind(table, looks, config.association)
    state = association.solve()
    if account is not None:
        account.pairs(association.judged(table, looks, config.association), table, looks)
    table.mean, table.covariance = state
    rows, columns = association.pairs()
    if looks.is_described.any():
        learn_appearance(table, looks, rows, columns, config.life.template_time)
        look_at(table, looks, rows, columns, config.life.look_time)
    note(table, looks, rows, columns)
    free = np.ones((len(looks.seconds), len(table)), bool)
    free[looks.picture[columns], rows] = False
    keep_members(table, looks, free, config, account)
    left = np.ones(len(looks.picture), bool)
    left[columns] = False
    left[association.consumed] = False
    return looks.single[left[looks.single]]


def note(table: TrackTable, looks: Looks, rows: Indices, columns: Indices) -> None:
    """Note in tracks (k,) what the detections (k,) tell beside place and colours."""
    stamp_ns, camera = looks.stamp_ns[columns], looks.camera[columns]
    np.maximum.at(table.seen_ns, rows, stamp_ns)
    table.kept_ns[rows] = table.seen_ns[rows]
    table.seen_by_ns[rows, camera] = stamp_ns
    table.local_id[rows, camera] = looks.detections.local_id[columns]
    np.bitwise_or.at(table.cameras, rows, np.left_shift(1, camera).astype(np.uint32))
    told = looks.detections.class_id[columns]
    table.class_id[rows[told > 0]] = told[told > 0]


def learn_appearance(
    table: TrackTable, looks: Looks, rows: Indices, columns: Indices, template_time: float
) -> None:
    """Mix into the templates of tracks (k,) those of detections (k,) that stand apart."""
    apart = ~looks.is_overlapped[columns]
    rows, columns = rows[apart], columns[apart]
    since = (looks.stamp_ns[columns] - table.seen_by_ns[rows, looks.camera[columns]]) / 1e9
    weight = np.minimum(since / template_time, 0.5)
    _mix_in(table.template, rows, looks.detections.template[columns], weight)


@compiled(types.void(types.Array(types.f4, 2, 'A'), INTS_1D, TEMPLATES, FLOATS_1D))
def _mix_in(template: Templates, rows: Indices, told: Templates, weight: Floats) -> None:
    """Mix what is told, one after the other, into rows of the templates; the first as it is."""
    for index in range(len(rows)):
        known = template[rows[index]]
        if told[index].any():
            share = weight[index] if known.any() else 1.0
            for bin in range(len(known)):
                known[bin] += share * (told[index, bin] - known[bin])


def keep_members(
    table: TrackTable,
    looks: Looks,
    free: NDArray[np.bool_],
    config: FusionConfig,
    account: Account | None = None,
) -> None:
    """
    Keep alive what merged detections hide of the tracks that are free, (pictures, n).

    Where others of the group are seen, only for a while: it may be that nobody is behind them.
    """
    groups, detections = looks.groups, looks.detections
    if len(groups) == 0:
        return
    picture, noise = looks.picture[groups], looks.noise[groups] * GROUP_INFLATION
    named = (table.track_id[:, None] == detections.members[groups, None]).any(axis=2)
    taken = (named & ~free[picture]).sum(axis=1)
    hidden_s = (looks.stamp_ns[groups, None] - table.seen_ns) / 1e9
    hoped = (hidden_s <= config.life.hidden_time) | (taken == 0)[:, None]
    squared = distances(
        table.mean, table.covariance, looks.seconds[picture], looks.position[groups], noise
    )
    hidden = free[picture] & table.confirmed & hoped & (squared < config.association.gate)
    for row in np.flatnonzero(hidden.any(axis=1)).tolist():
        candidates = np.flatnonzero(hidden[row] & free[picture[row]])
        order = np.lexsort((squared[row, candidates], ~named[row, candidates]))
        whole = named[row] & ~free[picture[row]]
        count = int(detections.member_count[groups[row]]) or len(candidates)
        members = np.sort(candidates[order[: max(count - int(whole.sum()), 0)]])
        if len(members):
            free[picture[row], members] = False
            whole[members] = True
            if account is not None:
                account.hidden(members, int(groups[row]), squared[row, members], table, looks)
            _keep(table, looks, int(groups[row]), members, whole, config.life.look_time)


def _keep(
    table: TrackTable,
    looks: Looks,
    group: int,
    members: Indices,
    whole: NDArray[np.bool_],
    longest_s: float,
) -> None:
    """Update the hidden members (k,) of a merged detection; `whole` (n,) is all of the group."""
    matrix = position_matrix(looks.seconds[looks.picture[group]])
    stamp_ns = looks.stamp_ns[group]
    since_ns = stamp_ns - table.hidden_ns[members, looks.camera[group]]
    table.mean[members], table.covariance[members] = update(
        table.mean[members],
        table.covariance[members],
        looks.position[[group]] - table.mean[members] @ matrix.T,
        np.repeat(looks.noise[[group]] * GROUP_INFLATION, len(members), axis=0),
        matrix,
    )
    table.kept_ns[members] = np.maximum(table.kept_ns[members], stamp_ns)
    table.hidden_ns[members, looks.camera[group]] = stamp_ns
    is_unseen = table.cameras[members] == 0
    unseen = members[is_unseen]
    _move_along(table, unseen, whole, np.minimum(since_ns[is_unseen] / 1e9, longest_s))
    if whole.sum() > 1:
        table.group_ns[unseen] = stamp_ns
        table.group[unseen] = table.track_id[whole].min()


def _move_along(
    table: TrackTable, hidden: Indices, whole: NDArray[np.bool_], seconds: NDArray[np.float64]
) -> None:
    """Let those (k,) whom no camera sees go on for a while (k,) as others of their group do."""
    shown = whole & (table.cameras > 0)
    if not shown.any():
        return
    velocity = table.mean[shown, 2:].mean(axis=0)
    table.mean[hidden], table.covariance[hidden] = update(
        table.mean[hidden],
        table.covariance[hidden],
        velocity - table.mean[hidden, 2:],
        COMPANY_DENSITY / seconds[:, None, None] * np.eye(2),
        VELOCITY,
    )
