"""The event-tracking paper's Figure 14: three who are one object from the first image on."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from mctrack_experiments.papers.event_tracking.fig16 import ASIDE, BEHIND, dressed, varied
from mctrack_experiments.papers.event_tracking.paths import with_past
from mctrack_experiments.papers.event_tracking.tracked_match import TrackedMatch
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import EventCode, Events
from mctrack_ros.recording import BagReader
from mctrack_ros.simulation import Scenario, Walk, staged

DURATION_S = 8.0
BEGUN_S = 1.0
"""From here on a path is expected: a track must first be confirmed, s."""

GATE_M = 1.5
WHOLE = 0.9
"""Share of its time that a path must cover to be whole."""

_DRIFT = 0.8  # m/s, of the three together
_APART_M = 0.5
_SPEED = 2.5  # m/s, of who leaves
_LEAVES = ((2.0, -1.0), (4.5, 1.0), (DURATION_S, 0.0))  # s, and to which side


def reproduce_fig14(
    seeds: Sequence[int], progress: Callable[[str], None] = lambda line: None
) -> Figures:
    """
    Let three walk behind one another in one camera's image, then part one by one.

    Parameters
    ----------
    seeds : sequence of int
        Of looks, noise and place; people of an even seed wear the same kit.
    progress : callable
        Told what is being done.

    """
    alone, whole, errors, people = 0, 0, [], 0
    for seed in seeds:
        progress(f'seed {seed}')
        truth, tracks, origin = play(seed)
        inherited = with_past(tracks, origin)
        for person in np.unique(truth.id).tolist():
            people += 1
            alone += _covered(truth, tracks, person)[0] >= WHOLE
            share, error_m = _covered(truth, inherited, person)
            whole += share >= WHOLE
            errors.append(error_m)
    return Figures(
        name='fig14',
        command='mctrack reproduce fig14',
        protocol={
            'scene': 'pitch5 with three people, one behind another in cam1, which is alone',
            'seeds': f'{len(seeds)}; people of every other seed wear the same kit',
            'whole': f'within {GATE_M:g} m of the player in {WHOLE:.0%} of the images from '
            f'{BEGUN_S:g} s on; the track is the one that follows him at the end',
        },
        figures={
            'people': people,
            'whole_share': whole / people,
            'whole_share.without_past': alone / people,
            'error_m': float(np.nanmean(errors)),
        },
    )


def play(seed: int) -> tuple[Trajectories, Trajectories, dict[int, int]]:
    """Return true and estimated trajectories, and of which track each was part before."""
    scenario = Scenario(seed=seed, duration_s=DURATION_S, cameras=1)
    with tempfile.TemporaryDirectory() as scratch:
        match = TrackedMatch.made(staged(scenario, walks(seed)), Path(scratch))
        with BagReader(match.tracked) as bag:
            told = [rows for rows, _ in bag.rows('/events', Events)]
        truth, tracks = match.trajectories()
    begun = truth.frame >= truth.frame.min() + round(BEGUN_S * scenario.rate_hz)
    origin = {
        int(rows.track_id[row]): int(rows.old_id[row])
        for rows in told
        for row in np.flatnonzero((rows.event == EventCode.SPLIT) & (rows.old_id > 0))
    }
    return truth.select(begun), tracks, origin


def walks(seed: int) -> list[Walk]:
    """Return who walks where."""
    place, _ = varied(seed)
    people = []
    for number, (leaves_s, side) in enumerate(_LEAVES):
        row = place + _APART_M * number * BEHIND
        aside_m = [0.0, _DRIFT * leaves_s]
        aside_m.append(_DRIFT * DURATION_S + side * _SPEED * (DURATION_S - leaves_s))
        stops = [
            (when_s, *(row + aside * ASIDE).tolist())
            for when_s, aside in zip((0.0, leaves_s, DURATION_S + 1e-6), aside_m)
        ]
        people.append(Walk(dressed(seed, number), tuple(stops)))
    return people


def _covered(truth: Trajectories, tracks: Trajectories, person: int) -> tuple[float, float]:
    """Return the share of somebody's time that his last track covers, and its error, m."""
    mine = truth.select(truth.id == person)
    last = tracks.select(tracks.frame == mine.frame.max())
    gap = np.linalg.norm(last.position - mine.position[mine.frame.argmax()], axis=1)
    if gap.min(initial=np.inf) > GATE_M:
        return 0.0, np.nan
    his = tracks.select(tracks.id == last.id[gap.argmin()])
    _, rows, places = np.intersect1d(mine.frame, his.frame, return_indices=True)
    apart = np.linalg.norm(mine.position[rows] - his.position[places], axis=1)
    near = apart <= GATE_M
    return float(near.sum() / len(mine)), float(apart[near].mean())
