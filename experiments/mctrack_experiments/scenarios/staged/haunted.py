"""Real cameras on rendered matches, told of targets that are not there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import closing
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.fusion.adapter import reported
from mctrack_ros.evaluation.instants import TRUTH_TOPIC, read_instants
from mctrack_ros.interfaces import Feedback, Tracks
from mctrack_ros.replay.lockstep import camera_tasks, run_lockstep
from mctrack_ros.replay.workers import CameraWorkers
from mctrack_ros.resources import config_file
from mctrack_ros.site.site import load_site

Floats = NDArray[np.float64]

WINDOW_S, TOLD_S, DIES_WITHIN_S = 4.0, 2.0, 1.0
AT_A_TIME = 4
CLEAR_M, NEAR_M = 5.0, 2.0
"""Ghosts are so far from everybody; a track so near to one is it."""
PITCH_M = (105.0, 68.0)
GHOST_ID = 900_000
SECOND_NS = 1_000_000_000


class HauntedWorkers(CameraWorkers):
    """
    Cameras whose feedback tells of targets that are not there.

    Attributes
    ----------
    ghosts : list of (k, 2) array
        Their places, m, window by window.
    first_ns : int
        When the first window begins, ns.

    """

    ghosts: Sequence[Floats] = ()
    first_ns = 0

    def announce(self, tick_index: int, feedback: Sequence[Any]) -> None:
        """Add this window's ghosts to the feedback of its first part."""
        super().announce(
            tick_index, [(session, self._haunted(each)) for session, each in feedback]
        )

    def _haunted(self, feedback: Feedback) -> Feedback:
        window, since_s = divmod((feedback.stamp_ns - self.first_ns) / SECOND_NS, WINDOW_S)
        if since_s >= TOLD_S or not 0 <= window < len(self.ghosts):
            return feedback
        places = self.ghosts[int(window)]
        told = Feedback.build(
            feedback.stamp_ns,
            position=np.column_stack([places, np.zeros(len(places))]),
            covariance=np.tile(np.diag([0.1, 0.1, 0.5, 0.5]), (len(places), 1, 1)),
            track_id=GHOST_ID + AT_A_TIME * int(window) + np.arange(len(places)),
        )
        return Feedback.joined(feedback.stamp_ns, [feedback, told])


def haunted(match: Path, seed: int, windows: int) -> list[bool]:
    """
    Track a match while its cameras are told of ghosts, two seconds each.

    Parameters
    ----------
    match : Path
        A rendered match with its truth.
    seed : int
        Of the ghosts' places.
    windows : int
        For how long, in windows of four seconds.

    Returns
    -------
    list of bool
        Of each ghost, whether nothing is reported there a second after it was told of last.

    """
    truth = read_instants(match, (TRUTH_TOPIC,))
    first_ns = truth.instants[0].stamp_ns
    ghosts = _clear_places(truth.instants, windows, first_ns, np.random.default_rng(seed))
    site = load_site(config_file('pitch5.yaml'))
    tasks = camera_tasks(match, site)
    ticks = round(windows * WINDOW_S * SECOND_NS / truth.period_ns)
    with closing(HauntedWorkers(tasks, len(tasks))) as workers:
        workers.ghosts, workers.first_ns = ghosts, first_ns
        tracked = islice(run_lockstep(workers, site), ticks)
        return dead(ghosts, [ticked.output.tracks for _, ticked in tracked], first_ns)


def dead(ghosts: Sequence[Floats], instants: Iterable[Tracks], first_ns: int) -> list[bool]:
    """Return of each ghost whether nobody is reported near it once it has had time to die."""
    alive = [np.zeros(len(places), bool) for places in ghosts]
    for tracks in instants:
        window, since_s = divmod((tracks.stamp_ns - first_ns) / SECOND_NS, WINDOW_S)
        if since_s > TOLD_S + DIES_WITHIN_S and 0 <= window < len(ghosts):
            gap = ghosts[int(window)][:, None] - reported(tracks)[1]
            near = np.linalg.norm(gap, axis=2) < NEAR_M
            alive[int(window)] |= near.any(axis=1)
    return [not lives for each in alive for lives in each.tolist()]


def _clear_places(
    truth: Sequence[Tracks], windows: int, first_ns: int, rng: np.random.Generator
) -> list[Floats]:
    """Return for each window places, (k, 2), that nobody comes near to meanwhile."""
    found = []
    for window in range(windows):
        begins_ns = first_ns + window * WINDOW_S * SECOND_NS
        ends_ns = begins_ns + WINDOW_S * SECOND_NS
        people = np.concatenate(
            [rows.position[:, :2] for rows in truth if begins_ns <= rows.stamp_ns < ends_ns]
        )
        places = rng.uniform(0, PITCH_M, (200, 2))
        gap = np.array([np.linalg.norm(people - place, axis=1).min() for place in places])
        found.append(places[gap > CLEAR_M][:AT_A_TIME])
    return found
