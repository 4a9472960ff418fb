"""Identity through a merge and a split of two: pairs who meet on the pitch, as told."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.papers.event_tracking.tracked_match import TrackedMatch
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import EventCode
from mctrack_ros.simulation import Scenario, Walk, staged

DURATION_S = 10.0
BEFORE_S, AFTER_S = (1.5, 2.3), (9.0, 10.0)
"""When ids are compared: all pairs meet and part between, s."""

GATE_M = 1.0
PLACES_M = np.array([(x, y) for y in (17.0, 51.0) for x in (13.0, 39.0, 66.0, 92.0)])
KITS = {
    'different': tuple((one, 11 + one) for one in range(8)),
    'same': ((0, 1), (2, 3), (4, 5), (6, 7), (11, 12), (13, 14), (15, 16), (17, 18)),
}
"""Who meets whom: 0 to 10 wear one team's kit, 11 to 21 the other's."""

Floats = NDArray[np.float64]
Stops = list[tuple[float, float, float]]
Meeting = Callable[[np.random.Generator], tuple[Stops, Stops]]


def cross(rng: np.random.Generator) -> tuple[Stops, Stops]:
    """Return the walks of two who cross at an angle, hardly an arm's length apart."""
    angle, miss = rng.uniform(0.7, np.pi), rng.uniform(0.3, 0.6)
    speed = rng.uniform(1.2, 2.5, 2)
    across = np.array([np.cos(angle), np.sin(angle)])
    return (
        [(when, speed[0] * (when - 5), 0.0) for when in (0.5, 9.5)],
        [(when, *(speed[1] * (when - 5) * across + [0.0, miss])) for when in (0.5, 9.5)],
    )


def meet(rng: np.random.Generator) -> tuple[Stops, Stops]:
    """Return the walks of two who meet, stand face to face and turn back."""
    stay, gap = rng.uniform(1.0, 2.5), rng.uniform(0.3, 0.45)
    times = (1.0, 4.0, 4.0 + stay, 7.0 + stay)
    return (
        [(when, -far, 0.0) for when, far in zip(times, (5.0, gap, gap, 5.0))],
        [(when, far, 0.0) for when, far in zip(times, (5.0, gap, gap, 5.0))],
    )


def accompany(rng: np.random.Generator) -> tuple[Stops, Stops]:
    """Return the walks of two who walk side by side for a while."""
    gap, speed = rng.uniform(0.3, 0.45), rng.uniform(0.8, 1.4)
    along = (-1.5 * speed, -1.5 * speed, 1.5 * speed, 1.5 * speed)
    times, aside = (1.0, 3.5, 6.5, 9.0), (4.0, gap, gap, 4.0)
    return (
        [(when, x, -y) for when, x, y in zip(times, along, aside)],
        [(when, x, y) for when, x, y in zip(times, along, aside)],
    )


def pass_by(rng: np.random.Generator) -> tuple[Stops, Stops]:
    """Return the walks of one who stands and one who passes."""
    miss, speed = rng.uniform(0.4, 0.7), rng.uniform(1.2, 2.5)
    return [(0.0, 0.0, 0.0)], [(when, speed * (when - 5), miss) for when in (0.5, 9.5)]


MEETINGS: tuple[Meeting, ...] = (cross, meet, accompany, pass_by)


def reproduce_pairs(
    seeds: Sequence[int], progress: Callable[[str], None] = lambda line: None
) -> Figures:
    """
    Let eight pairs at a time meet on the pitch, and count who keeps the global id.

    Parameters
    ----------
    seeds : sequence of int
        Of looks, noise, and how exactly the pairs meet.
    progress : callable
        Told what is being done.

    """
    figures: dict[str, float] = {}
    for kits in KITS:
        kept: list[bool] = []
        for seed in seeds:
            progress(f'pairs of {kits} kits, seed {seed}')
            kept += play(kits, seed)
        figures |= {f'{kits}.cases': len(kept), f'{kits}.kept': float(np.mean(kept))}
    return Figures(
        name='pairs',
        command='mctrack reproduce pairs',
        protocol={
            'scene': f'pitch5, 5 cameras, eight pairs at a time, {DURATION_S:g} s: '
            'two of each cross, meet face to face, walk side by side, or one passes the other',
            'seeds': f'{", ".join(map(str, seeds))}; the tracker is tuned on 1 to 6, 61 and 62',
            'cases': 'pairs who truly merge and split in some image',
            'kept': f'both have the ids afterwards that they had before, at {GATE_M:g} m',
        },
        figures=figures,
    )


def play(kits: str, seed: int, cameras: int = 5) -> list[bool]:
    """Return of every pair that truly merged and split whether both kept their ids."""
    scenario = Scenario(seed=seed, duration_s=DURATION_S, cameras=cameras)
    with tempfile.TemporaryDirectory() as scratch:
        match = TrackedMatch.made(staged(scenario, walks(kits, seed)), Path(scratch))
        events = [event for name in match.cameras for event in match.happenings(name)[0]]
        truth, tracks = match.trajectories()
    truly = [
        {event.targets for event in events if event.event == code}
        for code in (EventCode.MERGE, EventCode.SPLIT)
    ]
    kept = []
    for pair in KITS[kits]:
        people = frozenset(person + 1 for person in pair)
        if all(people in targets for targets in truly):
            before, after = (_ids(truth, tracks, people, when) for when in (BEFORE_S, AFTER_S))
            kept.append(before == after and len(set(before) - {0}) == len(people))
    return kept


def walks(kits: str, seed: int) -> list[Walk]:
    """Return what the pairs do: each kind of meeting twice, turned and placed by chance."""
    rng = np.random.default_rng([seed, 17])
    found = []
    for number, pair in enumerate(KITS[kits]):
        turn = rng.uniform(0, 2 * np.pi)
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        place = PLACES_M[number] + rng.uniform(-2, 2, 2)
        for person, stops in zip(pair, MEETINGS[number % len(MEETINGS)](rng)):
            course = [(when, *(place + rotation @ [x, y])) for when, x, y in stops]
            found.append(Walk(person, tuple((t, float(x), float(y)) for t, x, y in course)))
    return found


def _ids(
    truth: Trajectories,
    tracks: Trajectories,
    people: frozenset[int],
    when_s: tuple[float, float],
) -> list[int]:
    """Return the id that each of some people has most often in a time; 0: none."""
    rate = (truth.frame.max() + 1 - truth.frame.min()) / DURATION_S
    first, last = (truth.frame.min() + round(when * rate) for when in when_s)
    found = []
    for person in sorted(people):
        ids = []
        for row in np.flatnonzero(
            (truth.id == person) & (truth.frame >= first) & (truth.frame < last)
        ):
            there = np.flatnonzero(tracks.frame == truth.frame[row])
            gap = np.linalg.norm(tracks.position[there] - truth.position[row], axis=1)
            if gap.min(initial=np.inf) <= GATE_M:
                ids.append(int(tracks.id[there[gap.argmin()]]))
        found.append(int(np.bincount(ids).argmax()) if ids else 0)
    return found
