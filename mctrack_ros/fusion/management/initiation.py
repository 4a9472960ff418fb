"""New tracks from the detections that no track took."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from mctrack_ros.compiled import INTS_1D, compiled
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.measurements.admission import ROWS
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.motion.models import INITIAL_SPEED_SIGMA, Motion
from mctrack_ros.fusion.table import TRACKS, TrackTable
from mctrack_ros.fusion.update.update import note
from mctrack_ros.tracking.kalman import inverse, inverted

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
    label, count = _clusters(batch.rows[rows], config.association.gate, CLUSTER_M)
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
    together = _together(fresh.mean, table.mean, CROWD_M)
    if len(fresh) > room or together.max(initial=0) >= MOST_TOGETHER:
        kept = np.flatnonzero(together < MOST_TOGETHER)[:room]
        fresh, together = fresh.select(kept), together[kept]
    return fresh, np.flatnonzero(together)


def ask_more(fresh: TrackTable, table: TrackTable) -> None:
    """Ask more evidence of what begins very near a confirmed track: blobs fall apart."""
    near = cdist(fresh.mean[:, :2], table.mean[table.confirmed, :2]) < CROWD_M
    fresh.evidence[near.any(axis=1)] -= CROWD_EVIDENCE


def _together(fresh: Floats, others: Floats, reach: float) -> Indices:
    """Count who of the others, or of those before it, is within reach of each."""
    every = np.concatenate((others[:, :2], fresh[:, :2]))
    near = cdist(fresh[:, :2], every) < reach
    number = np.arange(len(every))
    return np.asarray((near & (number < number[len(others) :, None])).sum(axis=1))


def _clusters(reported: NDArray[Any], gate: float, reach: float) -> tuple[Indices, int]:
    """
    Join detections (k,) of different cameras that may be one target, the nearest pairs first.

    Returns
    -------
    cluster : (k,) array
        Of which each is, numbered by their first member; one a camera at most.
    count : int
        How many there are.

    """
    place, camera, number = reported['place'], reported['camera'], np.arange(len(reported))
    is_other = (camera[:, None] != camera) & (number[:, None] < number)
    one, other = ((cdist(place, place) < reach) & is_other).nonzero()
    if not len(one):
        return number, len(number)
    noise, apart = reported['noise'][one] + reported['noise'][other], place[other] - place[one]
    squared = (apart[:, None] @ inverse(noise) @ apart[..., None])[:, 0, 0]
    near = squared < gate
    order = squared[near].argsort(kind='stable')
    cluster, cameras = number.tolist(), [1 << each for each in camera.tolist()]
    for row, beside in zip(one[near][order].tolist(), other[near][order].tolist()):
        keep, drop = sorted((cluster[row], cluster[beside]))
        if keep != drop and not cameras[keep] & cameras[drop]:
            cameras[keep] |= cameras[drop]
            cluster = [keep if each == drop else each for each in cluster]
    label = {first: own for own, first in enumerate(dict.fromkeys(cluster))}
    return np.array([label[first] for first in cluster]), len(label)


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
