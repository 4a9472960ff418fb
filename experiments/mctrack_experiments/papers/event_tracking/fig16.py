"""The event-tracking paper's Figure 16: four situations that a camera cannot solve alone."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.papers.event_tracking.happenings import EventScore, score_events
from mctrack_experiments.papers.event_tracking.tracked_match import TrackedMatch
from mctrack_ros.evaluation import ground_timeline
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import EventCode
from mctrack_ros.simulation import Scenario, Walk, staged

DURATION_S = 9.0
GATE_M = 1.0
WINDOW_S = 0.5

WATCHED = 'cam1'
"""Whose image holds the groups; it looks north-east from the south-western corner."""

NEIGHBOUR = 'cam2'
"""Whose image is entered and left; it sees the groups from the side."""

SETTLED_S = 1.5
"""What is told before this is how tracking begins, s."""

PLACE_M = np.array([14.0, 36.0])
BEHIND = np.array([0.58, 0.815])
"""Where groups form, and the direction in which `WATCHED` looks there."""

ASIDE = np.array([-0.815, 0.58])
OUTSIDE_M, INSIDE_M = (18.0, 63.0), (13.0, 46.0)
"""Out of `NEIGHBOUR`'s image and in it; `WATCHED` sees both."""

Walks = Callable[[int], list[Walk]]


@dataclass(frozen=True, slots=True)
class Case:
    """
    One of the four situations.

    Attributes
    ----------
    name : str
        For its figures.
    title : str
        What happens.
    walks : callable
        Seed -> who does it how; people of an even seed wear the same kit.
    camera : str
        Whose events are judged.
    codes : tuple of EventCode
        Which ones.

    """

    name: str
    title: str
    walks: Walks
    camera: str
    codes: tuple[EventCode, ...]


def _meeting(seed: int) -> list[Walk]:
    """One stands, another passes behind and stays for a while."""
    place, delay = varied(seed)
    passes = [(0.0, 5.0), (2.0, 5.0), (4.0, 0.0), (5.5, 0.0), (7.5, -5.0)]
    return [
        _walk(dressed(seed, 0), [(0.0, *place)]),
        _walk(
            dressed(seed, 1),
            [(when + delay, *(place + 2 * BEHIND + aside * ASIDE)) for when, aside in passes],
        ),
    ]


def _parting(seed: int) -> list[Walk]:
    """Three meet behind one another, and part one after the other."""
    place, delay = varied(seed)
    sides, leave = (-4.0, 0.0, 4.0), (4.5, 99.0, 6.0)
    walks = []
    for number, (side, leaves) in enumerate(zip(sides, leave)):
        row = place + 1.6 * (number - 1) * BEHIND
        stops = [(1.0, side), (2.8, 0.0), (leaves, 0.0), (leaves + 2.0, side)]
        walks.append(
            _walk(
                dressed(seed, number),
                [(when + delay, *(row + aside * ASIDE)) for when, aside in stops],
            )
        )
    return walks


def _entering(seed: int) -> list[Walk]:
    """One walks into the neighbour's image, another is there."""
    place, delay = varied(seed)
    path = [(2.0 + delay, *OUTSIDE_M), (7.5 + delay, *INSIDE_M)]
    return [_walk(dressed(seed, 0), path), _walk(dressed(seed, 1), [(0.0, *place)])]


def _leaving(seed: int) -> list[Walk]:
    """One walks out of the neighbour's image, another stays."""
    place, delay = varied(seed)
    path = [(1.0 + delay, *INSIDE_M), (6.5 + delay, *OUTSIDE_M)]
    return [_walk(dressed(seed, 0), path), _walk(dressed(seed, 1), [(0.0, *place)])]


def varied(seed: int) -> tuple[NDArray[np.float64], float]:
    """Return where, m, and how much later, s, it happens with a seed."""
    rng = np.random.default_rng([seed, 16])
    return PLACE_M + rng.uniform(-1.5, 1.5, 2), float(rng.uniform(0, 0.5))


def dressed(seed: int, number: int) -> int:
    """Return who plays a part: team mates with an even seed, else of different kits."""
    return number if seed % 2 == 0 else (0, 11, 22)[number]


def _walk(person: int, stops: list[tuple[float, float, float]]) -> Walk:
    return Walk(person, tuple(stops))


CASES = (
    Case('grouping', 'two who merge in one camera, told apart by another', _meeting, WATCHED,
         (EventCode.MERGE, EventCode.SPLIT)),
    Case('splitting', 'three who merge and split twice', _parting, WATCHED, (EventCode.SPLIT,)),
    Case('entering', 'one who enters an image under the id of another camera', _entering,
         NEIGHBOUR, (EventCode.ENTER,)),
    Case('leaving', 'one who leaves an image', _leaving, NEIGHBOUR, (EventCode.EXIT,)),
)  # fmt: skip


def reproduce_fig16(
    seeds: Sequence[int], progress: Callable[[str], None] = lambda line: None
) -> Figures:
    """
    Stage, render and track each case with each seed.

    Parameters
    ----------
    seeds : sequence of int
        Of looks, noise and where exactly people walk.
    progress : callable
        Told what is being done.

    """
    figures: dict[str, float] = {}
    for case in CASES:
        score, kept, people = EventScore(), 0, 0
        for seed in seeds:
            progress(f'{case.title}, seed {seed}')
            found, switched, count = play(case, seed)
            score += found
            kept, people = kept + count - switched, people + count
        figures |= {
            f'{case.name}.true': score.true,
            f'{case.name}.precision': score.precision,
            f'{case.name}.recall': score.recall,
            f'{case.name}.one_id_share': kept / people,
        }
    return Figures(
        name='fig16',
        command='mctrack reproduce fig16',
        protocol={
            'scene': f'pitch5 with two or three people, cam1 and cam2, {DURATION_S:g} s a case',
            'seeds': f'{len(seeds)} a case; people of every other seed wear the same kit',
            'cases': '; '.join(f'{case.name}: {case.title}' for case in CASES),
            'pair': f'events of the same targets within {WINDOW_S:g} s, in the camera concerned',
            'one_id_share': 'people whose global track is never switched to another id',
        },
        figures=figures,
    )


def play(case: Case, seed: int) -> tuple[EventScore, int, int]:
    """Return how a case's events were told, how many people were switched, and of how many."""
    scenario = Scenario(seed=seed, duration_s=DURATION_S, cameras=2)
    walks = case.walks(seed)
    with tempfile.TemporaryDirectory() as scratch:
        match = TrackedMatch.made(staged(scenario, walks), Path(scratch))
        true, told = match.happenings(case.camera)
        truth, tracks = match.trajectories()
    begun_ns = scenario.start_ns + round(1e9 * SETTLED_S)
    true, told = (
        [each for each in events if each.event in case.codes and each.stamp_ns > begun_ns]
        for events in (true, told)
    )
    score = EventScore()
    for code in case.codes:
        mine, theirs = ([one for one in each if one.event == code] for each in (true, told))
        score += score_events(mine, theirs, WINDOW_S, 1.0)
    switched = np.unique(ground_timeline(truth, tracks, GATE_M).switch_truth_id)
    return score, len(switched), len(walks)
