"""All pictures of a tick against the tracks: assignment, update, what else is learned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.joint import JointAssignment
from mctrack_ros.fusion.looks import Looks
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.association import mahalanobis
from mctrack_ros.tracking.kalman import update

Indices = NDArray[np.intp]

GROUP_INFLATION = 9.0
"""How much less a merged detection says about one of its members: factor of its covariance."""


def match(table: TrackTable, looks: Looks, config: FusionConfig) -> Indices:
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

    Returns
    -------
    (k,) array
        The single detections that no track took.

    """
    joint = JointAssignment(table, looks, config.association)
    table.mean, table.covariance = joint.solve()
    rows, columns = joint.pairs()
    learn_appearance(table, looks, rows, columns, config.life.template_time)
    note(table, looks, rows, columns)
    free = np.ones((len(looks.matrix), len(table)), bool)
    free[looks.picture[columns], rows] = False
    for group in looks.groups.tolist():
        open_rows = free[looks.picture[group]]
        open_rows[keep_members(table, looks, group, open_rows, config)] = False
    left = np.ones(len(looks.picture), bool)
    left[columns] = False
    return looks.single[left[looks.single]]


def note(table: TrackTable, looks: Looks, rows: Indices, columns: Indices) -> None:
    """Note in tracks (k,) what the detections (k,) tell beside place and colours."""
    stamp_ns, camera = looks.stamp_ns[columns], looks.camera[columns]
    np.maximum.at(table.seen_ns, rows, stamp_ns)
    table.kept_ns[rows] = table.seen_ns[rows]
    table.seen_by_ns[rows, camera] = stamp_ns
    table.local_id[rows, camera] = looks.detections.local_id[columns]
    np.bitwise_or.at(table.cameras, rows, np.left_shift(1, camera).astype(np.uint32))
    for name in ('class_id', 'kit'):
        told = getattr(looks.detections, name)[columns]
        getattr(table, name)[rows[told > 0]] = told[told > 0]


def learn_appearance(
    table: TrackTable, looks: Looks, rows: Indices, columns: Indices, template_time: float
) -> None:
    """Mix into the templates of tracks (k,) those of detections (k,) that stand apart."""
    apart = ~looks.is_overlapped[columns]
    rows, columns = rows[apart], columns[apart]
    since = (looks.stamp_ns[columns] - table.seen_by_ns[rows, looks.camera[columns]]) / 1e9
    weight = np.minimum(since / template_time, 0.5)[:, None]
    told = looks.detections.template[columns]
    for picture in np.unique(looks.picture[columns]).tolist():
        one = (looks.picture[columns] == picture) & told.any(axis=1)
        known = table.template[rows[one]]
        share = np.where(known.any(axis=1, keepdims=True), weight[one], 1.0)
        table.template[rows[one]] = known + share * (told[one] - known)


def keep_members(
    table: TrackTable,
    looks: Looks,
    group: int,
    free: NDArray[np.bool_],
    config: FusionConfig,
) -> Indices:
    """
    Keep alive what a merged detection hides of the free tracks, (n,); return their rows.

    Where others of the group are seen, only for a while: it may be that nobody is behind them.
    """
    detections, noise = looks.detections, looks.noise[[group]] * GROUP_INFLATION
    matrix = looks.matrix[looks.picture[group]]
    predicted = table.mean @ matrix.T
    spread = matrix @ table.covariance @ matrix.T
    squared = mahalanobis(predicted, spread, looks.position[[group]], noise)[0][:, 0]
    named = (table.track_id[:, None] == detections.members[group]).any(axis=1)
    taken = int((named & ~free).sum())
    hidden_s = (looks.stamp_ns[group] - table.seen_ns) / 1e9
    hoped = (hidden_s <= config.life.hidden_time) | (taken == 0)
    near = squared < config.association.gate
    candidates = np.flatnonzero(free & table.confirmed & hoped & near)
    order = np.lexsort((squared[candidates], ~named[candidates]))
    count = int(detections.member_count[group]) or len(candidates)
    count = max(count - taken, 0)
    members = np.sort(candidates[order[:count]])
    if len(members) == 0:
        return members
    table.mean[members], table.covariance[members] = update(
        table.mean[members],
        table.covariance[members],
        looks.position[[group]] - predicted[members],
        np.repeat(noise, len(members), axis=0),
        matrix,
    )
    stamp_ns = looks.stamp_ns[group]
    table.kept_ns[members] = np.maximum(table.kept_ns[members], stamp_ns)
    table.hidden_ns[members, looks.camera[group]] = stamp_ns
    unseen = members[table.cameras[members] == 0]
    if len(members) + taken > 1:
        table.group_ns[unseen] = stamp_ns
        whole = named & ~free
        whole[members] = True
        table.group[unseen] = table.track_id[whole].min()
    return members
