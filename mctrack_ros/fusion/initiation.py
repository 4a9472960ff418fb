"""New tracks from the detections that no track took."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import COLUMN_2D, FLOATS_2D, FLOATS_3D, INTS_1D, compiled, inner
from mctrack_ros.fusion.gating import distance
from mctrack_ros.fusion.looks import Looks
from mctrack_ros.fusion.matching import note
from mctrack_ros.fusion.motion import Motion
from mctrack_ros.fusion.neighbours import nearest
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.tracking.kalman import inverted

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST_STARTS = 256
"""So many detections start tracks in one tick; whoever is still there has the next one."""
MOST_TOGETHER = 16
"""Where so many are within `crowd_distance` of it, no further track begins."""


def new_tracks(
    looks: Looks,
    rows: Indices,
    tick_ns: int,
    cameras: int,
    config: FusionConfig,
    motion: Motion,
) -> TrackTable:
    """
    Start a track from each cluster of unexplained detections; ids are not yet given.

    Parameters
    ----------
    looks : Looks
        The pictures of the tick.
    rows : (k,) int array
        Detections that no track explains, of one picture a camera at most.
    tick_ns : int
        The tick's stamp, ns.
    cameras : int
        How many cameras the site has.
    config : FusionConfig
        Parameters.
    motion : Motion
        How tracks move.

    """
    rows = rows[:MOST_STARTS]
    label, mean, covariance = _begun(
        looks.position,
        looks.noise,
        looks.camera,
        rows,
        config.association.gate,
        config.life.cluster_distance,
        config.motion.initial_speed_sigma**2,
    )
    table = TrackTable.blank(len(mean), cameras, motion.modes)
    table.mean, table.covariance = mean, covariance
    motion.begin(table)
    note(table, looks, label, rows)
    if looks.has_templates:
        told = np.flatnonzero(looks.is_described[rows])[::-1]  # the first one's stays
        table.template[label[told]] = looks.detections.template[rows[told]]
    table.first_ns = table.seen_ns = table.kept_ns = tick_ns
    return table


def with_room(
    fresh: TrackTable, table: TrackTable, config: FusionConfig
) -> tuple[TrackTable, bool]:
    """
    Return the new tracks that there is room for: in the table, and where they begin.

    And whether any of them may be beside another track, within `crowd_distance`.
    """
    room = max(config.life.most_tracks - len(table), 0)
    together, most = _together(fresh.mean, table.mean, config.life.crowd_distance)
    if len(fresh) <= room and most < MOST_TOGETHER:
        return fresh, most > 0
    return fresh.select(np.flatnonzero(together < MOST_TOGETHER)[:room]), most > 0


def doubt_parts(fresh: TrackTable, table: TrackTable, config: FusionConfig) -> None:
    """Ask more evidence of new tracks that begin beside a confirmed one: blobs fall apart."""
    _, gap = nearest(fresh.mean, table.mean, table.confirmed)
    fresh.evidence[gap < config.life.crowd_distance] -= config.life.crowd_evidence


@compiled(types.Tuple([types.i8[::1], types.i8])(COLUMN_2D, COLUMN_2D, types.f8))
def _together(fresh: Floats, others: Floats, reach: float) -> tuple[Indices, int]:
    """Count who of the others, or of those before it, is within reach of each; and at most."""
    count, before = np.zeros(len(fresh), np.int64), len(others)
    place = np.empty((before + len(fresh), 2))  # the others are far apart in memory
    for row in range(before):
        place[row, 0], place[row, 1] = others[row, 0], others[row, 1]
    for row in range(len(fresh)):
        own_x, own_y = fresh[row, 0], fresh[row, 1]
        for other in range(before + row):
            x, y = place[other, 0] - own_x, place[other, 1] - own_y
            count[row] += x * x + y * y < reach * reach
        place[before + row, 0], place[before + row, 1] = own_x, own_y
    return count, count.max()


@inner
def _clusters(
    position: Floats, noise: Floats, camera: Indices, gate: float, reach: float
) -> Indices:
    """
    Join detections of different cameras that may be one target, the nearest pairs first.

    Returns
    -------
    (m,) array
        Cluster of each detection, numbered by their first member; one a camera at most.

    """
    count = len(position)
    near = np.empty((count * (count - 1) // 2, 2), np.int64)
    squared, found = np.empty(len(near)), 0
    for one in range(count):
        for other in range(one + 1, count):
            x = position[other, 0] - position[one, 0]
            y = position[other, 1] - position[one, 1]
            if camera[one] != camera[other] and x * x + y * y < reach * reach:
                apart = distance(
                    x,
                    y,
                    noise[one, 0, 0] + noise[other, 0, 0],
                    noise[one, 0, 1] + noise[other, 0, 1],
                    noise[one, 1, 1] + noise[other, 1, 1],
                )[0]
                if apart < gate:
                    near[found, 0], near[found, 1] = one, other
                    squared[found], found = apart, found + 1
    cluster, cameras = np.arange(count), np.left_shift(1, camera)
    for pair in np.argsort(squared[:found], kind='mergesort'):
        one, other = cluster[near[pair, 0]], cluster[near[pair, 1]]
        if one != other and not cameras[one] & cameras[other]:
            keep, drop = min(one, other), max(one, other)
            cameras[keep] |= cameras[drop]
            cluster[cluster == drop] = keep
    number, clusters = np.empty(count, np.int64), 0
    for row in range(count):
        if cluster[row] == row:
            number[row], clusters = clusters, clusters + 1
        else:
            number[row] = number[cluster[row]]
    return number


@inner
def _fused(
    position: Floats, noise: Floats, label: Indices, speed_variance: float
) -> tuple[Floats, Floats]:
    """Return states (k, 4) and covariances (k, 4, 4): clusters' weighted means, at rest."""
    count = label.max() + 1
    information, weighted = np.zeros((count, 2, 2)), np.zeros((count, 2))
    weight = np.empty((2, 2))
    for row in range(len(label)):
        inverted(noise[row], weight)
        for i in range(2):
            for j in range(2):
                information[label[row], i, j] += weight[i, j]
                weighted[label[row], i] += weight[i, j] * position[row, j]
    mean, covariance = np.zeros((count, 4)), np.zeros((count, 4, 4))
    for one in range(count):
        inverted(information[one], weight)
        for i in range(2):
            covariance[one, 2 + i, 2 + i] = speed_variance
            for j in range(2):
                covariance[one, i, j] = weight[i, j]
                mean[one, i] += weight[i, j] * weighted[one, j]
    return mean, covariance


@compiled(
    types.Tuple([types.i8[::1], types.f8[:, ::1], types.f8[:, :, ::1]])(
        FLOATS_2D, FLOATS_3D, INTS_1D, INTS_1D, types.f8, types.f8, types.f8
    )
)
def _begun(
    position: Floats, noise: Floats, camera: Indices, rows: Indices, gate: float, reach: float,
    speed_variance: float,
) -> tuple[Indices, Floats, Floats]:  # fmt: skip
    """Return of which track each of the rows (k,) is, and states and covariances of these."""
    position, noise = position[rows], noise[rows]
    label = _clusters(position, noise, camera[rows], gate, reach)
    mean, covariance = _fused(position, noise, label, speed_variance)
    return label, mean, covariance
