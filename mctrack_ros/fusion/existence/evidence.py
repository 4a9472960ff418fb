"""What the cameras see of each track, weighed against what they should see."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, INTS_1D, compiled, inner
from mctrack_ros.fusion.config import CORRELATED_S, MISSED_IMAGES
from mctrack_ros.fusion.existence.detection_probability import DetectionProbability, expect, learn
from mctrack_ros.fusion.existence.view_overlap import ViewOverlap
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TRACKS, TrackTable

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]

MISS_WEIGHT = 0.8
"""How much a miss counts for a confirmed track, which may be hidden for a while; 1 costs .07 IDF1
on the terrace."""

MOST_EVIDENCE = 8.0
"""Log-odds are counted no further than this: twice what confirms."""

IN_VIEW = 0.5
"""Where a camera sees people more probably, it has a view."""

SOLE_VIEW_LOG_ODDS = -math.log1p(-IN_VIEW)
"""If the misses of all other live cameras would say less, hardly any has a view [log-odds]."""

TIMEOUTS = 2.0
"""A camera that is silent for so many times the batcher's patience has a view of nothing."""

LONGEST_INTERVAL_S = 10.0
"""No camera is taken to be slower than this, s."""

SURE_S = 0.5
"""What has been there for so long shows which cameras have a view there, confirmed or not, s."""


class Evidence:
    """
    Weighs what the cameras see of each track against what they should see.

    Parameters
    ----------
    cameras : int
        How many there are.
    config : JointConfig
        Parameters.

    """

    def __init__(self, cameras: int, config: JointConfig) -> None:
        self._management = management = config.management
        self._alive_s = TIMEOUTS * config.batching.patience
        self._cameras = cameras
        self._coverage = DetectionProbability(
            cameras, management.coverage_cell, management.coverage_prior
        )
        self._common = ViewOverlap(cameras)
        self._silent_s = np.full(cameras, np.inf)
        self._interval_s = np.zeros(cameras)

    def count(self, table: TrackTable, batch: Batch, tick_ns: int, seconds: float) -> Mask:
        """
        Add one tick's evidence to the log-odds, and confirm.

        A miss lowers the log-odds only of a track that exactly one camera sees. A track that two
        see is real. A track that none sees may be hidden: it coasts, and its misses are added up
        apart, up to `MOST_EVIDENCE`, once no live camera's latest image shows it. That sum
        returns to 0 when two cameras see the track in one tick, or one does where hardly any
        other can; an observation by one of many cameras, or in a group, lowers it by
        `hit_evidence`. A camera does not miss a track that it sees in a group. Where nothing is
        known yet, a camera that has seen nobody together with the only one that sees a track
        hardly misses it. A track that is not confirmed is judged by a cumulative sum (Page 1954,
        "Continuous inspection schemes"), so that misses before it came into view do not count.

        Parameters
        ----------
        table : TrackTable
            Changed in place.
        batch : Batch
            The tick's images.
        tick_ns : int
            The tick's stamp, ns.
        seconds : float
            Time since the last tick, s.

        Returns
        -------
        (n,) bool array
            The newly confirmed.

        """
        management, coverage = self._management, self._coverage
        self._silent_s += seconds
        since_s = np.where(np.isfinite(self._silent_s), self._silent_s, seconds)
        self._note_intervals(batch.cameras)
        newly, seen, could = _counted(
            table.fixed,
            table.hidden_ns,
            batch.cameras,
            tick_ns - round(seconds * 1e9),
            self._silent_s <= np.maximum(self._alive_s, MISSED_IMAGES * self._interval_s),
            coverage.seconds,
            coverage.cell,
            coverage.prior,
            self._common.share(),
            seconds,
            np.minimum(since_s / CORRELATED_S, 1.0),
            self._interval_s,
            management.hit_evidence,
            MISS_WEIGHT,
            management.confirm_evidence,
        )
        sure = tick_ns - table.first_ns >= SURE_S * 1e9
        self._common.learn(seen, could, sure, min(seconds, CORRELATED_S))
        return newly

    def _note_intervals(self, cameras: NDArray[np.intp]) -> None:
        """Note that cameras, (k,), have sent an image; one long gap is not their pace."""
        silent_s, interval_s = self._silent_s[cameras], self._interval_s[cameras]
        longest_s = np.where(interval_s > 0.0, 2 * interval_s, LONGEST_INTERVAL_S)
        known = (silent_s > 0.0) & np.isfinite(silent_s)
        self._interval_s[cameras] = np.where(known, np.minimum(silent_s, longest_s), interval_s)
        self._silent_s[cameras] = 0.0


@inner
def _weighed(
    tracks: Any,
    hidden_ns: NDArray[np.int64],
    present: Mask,
    alive: Mask,
    begin_ns: int,
    is_judged: Mask,
    probability: Floats,
    shares: Floats,
    interval_s: Floats,
    share: float,
    hit: float,
    miss_weight: float,
    enough: float,
) -> tuple[Mask, Mask, Mask]:
    """
    Weigh a tick and confirm, in place.

    Misses speak of the tracks that `is_judged`, (n,), by the `probability`, (n, cameras), of being
    seen. `share` is how much of a whole observation the tick is, `shares`, (cameras,), how much
    each camera's image in it is, and `interval_s`, (cameras,), each camera's interval.

    Returns
    -------
    newly : (n,) bool array
        Who was confirmed.
    seen, reported : (n, cameras) bool arrays
        Which cameras saw each track, and which could have as another one did.

    """
    cameras, confirmed, evidence = tracks['cameras'], tracks['confirmed'], tracks['evidence']
    missed, shown_by, kept_ns = tracks['missed'], tracks['shown_by'], tracks['kept_ns']
    newly = np.zeros(len(cameras), np.bool_)
    seen, reported = np.zeros(hidden_ns.shape, np.bool_), np.zeros(hidden_ns.shape, np.bool_)
    for track in range(len(cameras)):
        count, gain, loss, others, slowest_s, back = 0, 0.0, 0.0, 0.0, 0.0, share
        shown = shown_by[track]
        for camera in range(len(present)):
            if cameras[track] >> camera & 1:
                seen[track, camera] = True
                count += 1
        weight = miss_weight if confirmed[track] else 1.0
        for camera in range(len(present)):
            own, hidden = seen[track, camera], hidden_ns[track, camera] > begin_ns
            watched = present[camera] and (own or not hidden)
            reported[track, camera] = watched and count > own
            if present[camera] or not alive[camera]:
                shown &= ~np.uint32(1 << camera)
                shown |= np.uint32((own or hidden) << camera)
            if own or hidden:
                slowest_s = max(slowest_s, interval_s[camera])
                back = max(back, shares[camera] if present[camera] else 0.0)
            if own:
                gain += shares[camera] * hit
                continue
            if not is_judged[track]:
                continue
            miss = -np.log1p(-probability[track, camera])
            others += miss if alive[camera] and not hidden else 0.0
            if watched:
                gain -= shares[camera] * weight * miss if count else 0.0
                loss += shares[camera] * miss
        shown_by[track] = shown
        if slowest_s > 0.0:
            tracks[track]['pace_s'] = slowest_s
        if count > 1 or (count and others < SOLE_VIEW_LOG_ODDS):
            missed[track] = 0.0
        elif kept_ns[track] > begin_ns:  # by one of many cameras, or a group: he may not be back
            missed[track] = max(missed[track] - back * hit, 0.0)
        elif not shown:
            missed[track] = min(missed[track] + loss, MOST_EVIDENCE)
        lowest = -MOST_EVIDENCE if confirmed[track] else min(evidence[track], 0.0)
        evidence[track] = min(max(evidence[track] + gain, lowest), MOST_EVIDENCE)
        newly[track] = not confirmed[track] and evidence[track] >= enough
        confirmed[track] |= newly[track]
    return newly, seen, reported


@compiled(
    types.Tuple([types.b1[::1], types.b1[:, ::1], types.b1[:, ::1]])(
        TRACKS, types.Array(types.i8, 2, 'A', readonly=True), INTS_1D, types.i8,
        BOOLS_1D, types.f8[:, :, :, ::1], types.f8, types.f8, types.f8[:, ::1],
        types.f8, types.f8[::1], types.f8[::1], types.f8, types.f8, types.f8,
    )
)  # fmt: skip
def _counted(
    tracks: Any, hidden_ns: NDArray[np.int64], reporting: Indices, begin_ns: int,
    alive: Mask, known: Floats, cell: float, prior: float,
    common: Floats, seconds: float, shares: Floats, interval_s: Floats, hit: float,
    miss_weight: float, enough: float,
) -> tuple[Mask, Mask, Mask]:  # fmt: skip
    """
    Weigh a tick by what is known of the coverage, and learn that; see `Evidence.count`.

    Where nothing is known, the `prior` of each camera is multiplied by what it has in `common`,
    (cameras, cameras), with the only one that sees the track. Returns what `_weighed` does.
    """
    mean, cameras, confirmed = tracks['mean'], tracks['cameras'], tracks['confirmed']
    present = np.zeros(hidden_ns.shape[1], np.bool_)
    present[reporting] = True
    is_judged, probability = np.zeros(len(cameras), np.bool_), np.empty(hidden_ns.shape)
    for track in range(len(cameras)):
        sole = cameras[track] & (cameras[track] - 1) == 0  # at most one camera's bit is set
        if not sole:
            continue
        is_judged[track], expected = True, probability[track]
        expected[:] = prior
        for camera in range(len(common) if cameras[track] else 0):
            if cameras[track] >> camera & 1:
                expected *= common[camera]
        expect(mean[track], known, cell, expected)
    newly, is_seen, is_reported = _weighed(
        tracks,
        hidden_ns,
        present,
        alive,
        begin_ns,
        is_judged,
        probability,
        shares,
        interval_s,
        min(seconds / CORRELATED_S, 1.0),
        hit,
        miss_weight,
        enough,
    )
    learn(mean, confirmed, is_seen, is_reported, min(seconds, CORRELATED_S), known, cell)
    return newly, is_seen, is_reported
