"""All pictures of a tick against the tracks: assignment, update, what else is learned."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.joint import JointAssignment
from mctrack_ros.fusion.looks import Look
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.association import mahalanobis
from mctrack_ros.tracking.kalman import update

Indices = NDArray[np.intp]

GROUP_INFLATION = 9.0
"""How much less a merged detection says about one of its members: factor of its covariance."""


def match(table: TrackTable, looks: Sequence[Look], config: FusionConfig) -> list[Indices]:
    """
    Associate the pictures of a tick with the tracks and update these.

    Parameters
    ----------
    table : TrackTable
        The tracks, predicted to the tick's stamp; changed in place.
    looks : sequence of Look
        The pictures, in canonical order.
    config : FusionConfig
        Parameters.

    Returns
    -------
    list of (k,) arrays
        The single detections of each picture that no track took.

    """
    if not looks:
        return []
    joint = JointAssignment(table, looks, config.association)
    table.mean, table.covariance = joint.solve()
    left = []
    for number, look in enumerate(looks):
        rows, columns = joint.pairs(number)
        note(table, look, rows, look.single[columns], config.life.template_time)
        left.append(np.delete(look.single, columns))
        free = np.ones(len(table), bool)
        free[rows] = False
        for group in look.groups.tolist():
            free[keep_members(table, look, group, free, config.association.gate)] = False
    return left


def note(
    table: TrackTable, look: Look, rows: Indices, columns: Indices, template_time: float
) -> None:
    """Note in tracks (k,) what the detections (k,) of a picture tell beside positions."""
    if len(rows) == 0:
        return
    stamp_ns, camera = look.detections.stamp_ns, look.camera
    _learn_appearance(table, look, rows, columns, template_time)
    table.seen_ns[rows] = table.kept_ns[rows] = np.maximum(table.seen_ns[rows], stamp_ns)
    table.seen_by_ns[rows, camera] = stamp_ns
    table.local_id[rows, camera] = look.detections.local_id[columns]
    table.cameras[rows] |= np.uint32(1 << camera)
    for name in ('class_id', 'kit'):
        told = getattr(look.detections, name)[columns]
        known = getattr(table, name)
        known[rows] = np.where(told > 0, told, known[rows])


def _learn_appearance(
    table: TrackTable, look: Look, rows: Indices, columns: Indices, template_time: float
) -> None:
    template = look.detections.template[columns]
    told = template.any(axis=1) & ~look.is_overlapped[columns]
    rows, template = rows[told], template[told]
    known = table.template[rows]
    since = (look.detections.stamp_ns - table.seen_by_ns[rows, look.camera]) / 1e9
    weight = np.minimum(since / template_time, 0.5)
    weight = np.where(known.any(axis=1), weight, 1.0)[:, None]
    table.template[rows] = known + weight * (template - known)


def keep_members(
    table: TrackTable, look: Look, group: int, free: NDArray[np.bool_], gate: float
) -> Indices:
    """Keep alive what a merged detection hides of the free tracks, (n,); return their rows."""
    detections, noise = look.detections, look.noise[[group]] * GROUP_INFLATION
    predicted = table.mean @ look.matrix.T
    spread = look.matrix @ table.covariance @ look.matrix.T
    squared = mahalanobis(predicted, spread, look.position[[group]], noise)[0][:, 0]
    named = np.isin(table.track_id, detections.members[group])
    candidates = np.flatnonzero(free & table.confirmed & (squared < gate))
    order = np.lexsort((squared[candidates], ~named[candidates]))
    count = int(detections.member_count[group]) or len(candidates)
    members = np.sort(candidates[order[:count]])
    if len(members) == 0:
        return members
    table.mean[members], table.covariance[members] = update(
        table.mean[members],
        table.covariance[members],
        look.position[[group]] - predicted[members],
        np.repeat(noise, len(members), axis=0),
        look.matrix,
    )
    stamp_ns = detections.stamp_ns
    table.kept_ns[members] = np.maximum(table.kept_ns[members], stamp_ns)
    table.group_ns[members] = table.hidden_ns[members, look.camera] = stamp_ns
    table.group[members] = table.track_id[members].min() if len(members) > 1 else 0
    return members
