"""New tracks from the detections that no track took."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import COLUMN_2D, INTS_1D, compiled
from mctrack_ros.fusion.association.gating import distance
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.measurements.admission import ROWS
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import INITIAL_SPEED_SIGMA, Motion
from mctrack_ros.fusion.neighbours import nearest
from mctrack_ros.fusion.table import TRACKS, TrackTable
from mctrack_ros.fusion.update.update import note
from mctrack_ros.tracking.kalman import inverted

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST_STARTS = 256
"""Most detections that start tracks in one tick, of all cameras in turn."""
CLUSTER_M = 1.5
"""Unassigned detections of two cameras farther apart start no common track, m: several times what
feet are off by."""
CROWD_M = 1.0
"""What begins so near to a confirmed track is at first taken for a part of it, m."""
CROWD_EVIDENCE = 4.0
"""Log-odds that it lacks then: as many as confirm a track; worth .03 MOTA and .07 IDF1 on CMC2."""
MOST_TOGETHER = 16
"""Where so many are within `CROWD_M` of it, no further track begins."""


def new_tracks(
    batch: Batch,
    rows: Indices,
    tick_ns: int,
    next_id: int,
    cameras: int,
    config: JointConfig,
    motion: Motion,
) -> TrackTable:
    """
    Start a track from each cluster of unexplained detections.

    Parameters
    ----------
    batch : Batch
        The images of the tick.
    rows : (k,) int array
        Detections that no track explains, of one image a camera at most.
    tick_ns : int
        The tick's stamp, ns.
    next_id : int
        Id of the first one; the others' follow.
    cameras : int
        How many cameras the site has.
    config : JointConfig
        Parameters.
    motion : Motion
        How tracks move.

    """
    rows = _shared_out(rows, batch.camera[rows])
    label, count = _clusters(batch.rows, rows, config.association.gate, CLUSTER_M)
    table = TrackTable.blank(count, cameras, motion.modes)
    note(table, batch, label, rows)
    speed_variance = INITIAL_SPEED_SIGMA**2
    _fuse(table.fixed, batch.rows, rows, label, speed_variance, tick_ns, next_id)
    motion.begin(table)
    if batch.has_templates:
        reported = np.flatnonzero(batch.is_described[rows])[::-1]  # the first one's stays
        table.template[label[reported]] = batch.detections.template[rows[reported]]
    return table


def _shared_out(rows: Indices, camera: Indices) -> Indices:
    """Return as many as may start, in their order: the first of each camera, the second ..."""
    if len(rows) <= MOST_STARTS:
        return rows
    order = np.argsort(camera, kind='stable')
    begin = np.flatnonzero(np.diff(camera[order], prepend=-1))
    turn = np.empty(len(rows), np.int64)
    turn[order] = np.arange(len(rows)) - np.repeat(begin, np.diff(begin, append=len(rows)))
    return np.asarray(rows[np.sort(np.argsort(turn, kind='stable')[:MOST_STARTS])])


def with_room(
    fresh: TrackTable, table: TrackTable, config: JointConfig
) -> tuple[TrackTable, Indices]:
    """
    Return the new tracks that there is room for: in the table, and where they begin.

    And rows of those, (k,), that are beside others, within `CROWD_M`.
    """
    room = max(config.management.most_tracks - len(table), 0)
    together, most = _together(fresh.mean, table.mean, CROWD_M)
    if len(fresh) > room or most >= MOST_TOGETHER:
        kept = np.flatnonzero(together < MOST_TOGETHER)[:room]
        fresh, together = fresh.select(kept), together[kept]
    return fresh, np.flatnonzero(together)


def ask_more(fresh: TrackTable, table: TrackTable) -> None:
    """Ask more evidence of what begins very near a confirmed track: blobs fall apart."""
    _, gap = nearest(fresh.mean, table.mean, table.confirmed)
    fresh.evidence[gap < CROWD_M] -= CROWD_EVIDENCE


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


@compiled(types.Tuple([types.i8[::1], types.i8])(ROWS, INTS_1D, types.f8, types.f8))
def _clusters(reported: Any, rows: Indices, gate: float, reach: float) -> tuple[Indices, int]:
    """
    Join detections of different cameras that may be one target, the nearest pairs first.

    Returns
    -------
    cluster : (k,) array
        Of which each of the rows is, numbered by their first member; one a camera at most.
    count : int
        How many there are.

    """
    position, noise, camera = (
        reported['place'][rows],
        reported['noise'][rows],
        reported['camera'][rows],
    )
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
    return number, clusters


@compiled(types.void(TRACKS, ROWS, INTS_1D, INTS_1D, types.f8, types.i8, types.i8))
def _fuse(
    tracks: Any, reported: Any, rows: Indices, label: Indices, speed_variance: float, tick_ns: int,
    next_id: int,
) -> None:  # fmt: skip
    """Begin blank tracks: at rest, at the weighted means of the clusters (k,) of rows (k,)."""
    mean, covariance = tracks['mean'], tracks['covariance']
    position, noise = reported['place'], reported['noise']
    information, weighted = np.zeros((len(tracks), 2, 2)), np.zeros((len(tracks), 2))
    weight = np.empty((2, 2))
    for row, own in zip(rows, label):
        inverted(noise[row], weight)
        for i in range(2):
            for j in range(2):
                information[own, i, j] += weight[i, j]
                weighted[own, i] += weight[i, j] * position[row, j]
    for one in range(len(tracks)):
        inverted(information[one], weight)
        for i in range(2):
            covariance[one, 2 + i, 2 + i] = speed_variance
            for j in range(2):
                covariance[one, i, j] = weight[i, j]
                mean[one, i] += weight[i, j] * weighted[one, j]
        track = tracks[one]
        track['first_ns'] = track['seen_ns'] = track['kept_ns'] = tick_ns
        track['track_id'] = next_id + one
