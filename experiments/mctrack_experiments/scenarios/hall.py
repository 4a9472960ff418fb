"""The hall: people close by, groups through one door, with and without shadows, by defaults."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from mctrack_experiments.bench.workers import Progress, silent
from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import REPORTED, Detections, Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.track import track_bag
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import HallScenario, World
from mctrack_ros.simulation.indoor import hall
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.site import load_site

Floats = NDArray[np.float64]

GATES_M = (0.5, 1.0)
NEAR_M = 1.0
"""A track this near to somebody is his, and no false one."""
FEET_M = 2.5
"""A foot of the shaded camera farther from everybody is nobody's."""
ENTERING_S, LEFT_S = 3.0, 10.0
"""Groups enter until so long after the last of them; tracks are left over for at most so long."""
SHADED = 'cam1'
KINDS = {'shadows': (True, False), 'plain': (False, False), 'joint': (True, True)}
"""Name of the figures: whether there are shadows, whether the joint tracker is chosen."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """
    What one recording gave.

    Attributes
    ----------
    scores : dict of str to float
        CLEAR MOT and IDF1.
    feet : array
        Of each foot of the shaded camera the distance to the nearest person, m.
    delays : array
        Of each person from the door to the first tick with a track, s; inf: never.
    entering : array
        Tracks a person, of each tick in which a group of two or three enters.
    left_over_s : float
        Time of false tracks where somebody was before, s a minute.
    false_s : float
        Time of all false tracks, s a minute.

    """

    scores: dict[str, float]
    feet: Floats
    delays: Floats
    entering: Floats
    left_over_s: float
    false_s: float


def reproduce_hall(
    seeds: Sequence[int], progress: Progress = silent, duration_s: float = 55.0
) -> Figures:
    """
    Render and track recordings of the hall, each with shadows and without.

    Parameters
    ----------
    seeds : sequence of int
        One recording each.
    progress : callable
        Told how many are done, of how many.
    duration_s : float
        Length of each, s.

    """
    total = len(KINDS) * len(seeds)
    figures: dict[str, float] = {}
    for done, (name, (has_shadows, is_joint)) in enumerate(KINDS.items()):
        outcomes = []
        for index, seed in enumerate(seeds):
            progress(done * len(seeds) + index, total)
            scenario = HallScenario(seed=seed, duration_s=duration_s, shadows=has_shadows)
            outcomes.append(_tracked(scenario, is_joint))
        figures |= {f'{name}.{key}': value for key, value in summary(outcomes).items()}
    progress(total, total)
    _, why = with_tracker(load_site(config_file('hall.yaml')))
    protocol = {
        'scene': f'hall, four cameras, {duration_s:g} s of 12.5 images a second each, with '
        f'shadows towards {SHADED} and without',
        'seeds': ', '.join(map(str, seeds)),
        'settings': 'config/hall.yaml: calibration by clicks of half a pixel of noise, and rate; '
        'all else by default, no background is given',
        'tracker': why,
        'joint': 'with shadows, fusion.tracker joint',
        'counted': 'people and tracks in the area of the site',
        'figures': 'MOTA, IDF1 and seconds a minute: means over the recordings, sd their standard '
        'deviation; all else over all recordings together',
        'feet': f'detections of {SHADED}, distance to the nearest person within {FEET_M:g} m',
        'delay': f'from the door to the first tick with a track within {NEAR_M:g} m, one to one',
        'entering': 'tracks for each person of a group of two or three, within '
        f'{NEAR_M:g} m of one, until {ENTERING_S:g} s after its last came in',
        'left_over': f'tracks with nobody within {NEAR_M:g} m where somebody was in the last '
        f'{LEFT_S:g} s',
    }
    return Figures('hall', 'mctrack reproduce hall', protocol, figures)


def summary(outcomes: Sequence[Outcome]) -> dict[str, float]:
    """Return the figures of several recordings."""
    each = [
        outcome.scores
        | {'left_over_s_per_min': outcome.left_over_s, 'false_s_per_min': outcome.false_s}
        for outcome in outcomes
    ]
    figures: dict[str, float] = {}
    for key in each[0]:
        values = [scores[key] for scores in each]
        figures[key] = float(np.mean(values))
        figures[f'{key}.sd'] = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
    feet, delays, entering = (
        np.concatenate([getattr(outcome, name) for outcome in outcomes])
        for name in ('feet', 'delays', 'entering')
    )
    found = delays[np.isfinite(delays)]
    return figures | {
        'feet.median_m': float(np.median(feet)),
        'feet.p95_m': float(np.percentile(feet, 95)),
        'delay.median_s': float(np.median(found)),
        'delay.p95_s': float(np.percentile(found, 95)),
        'delay.never_share': 1 - len(found) / len(delays),
        'entering.tracks_per_person': float(np.mean(entering)),
        'entering.short_share': float(np.mean(entering < 1)),
    }


def _tracked(scenario: HallScenario, is_joint: bool) -> Outcome:
    """Render one recording and track it, by the tracker that the site gets or the joint one."""
    world = hall.hall_world(scenario)
    with tempfile.TemporaryDirectory(prefix='mctrack_hall_') as name:
        folder = Path(name)
        simulate(scenario, folder / 'bag', world=world)
        site = load_site(config_file('hall.yaml'))
        if is_joint:
            site = replace(site, names_tracker=True)
        track_bag(folder / 'bag', folder / 'out', site)
        with BagReader(folder / 'out' / 'bag') as bag:
            tracks = [rows for rows, _ in bag.rows('/tracks', Tracks)]
            feet = [rows for rows, _ in bag.rows(f'/{SHADED}/detections', Detections)]
    return outcome_of(world, tracks, feet)


def outcome_of(
    world: World, instants: Sequence[Tracks], detections: Sequence[Detections]
) -> Outcome:
    """Return what was measured, given the tracks of all ticks and the shaded camera's rows."""
    scenario = world.scenario
    place = world.motion.position
    there = world.active & _inside(place)
    tracks = _of_steps(world, instants)
    near = [cdist(place[step, there[step]], tracks[step]) for step in range(scenario.steps)]
    false = [
        rows[~(gaps < NEAR_M).any(axis=0)] if gaps.size else rows
        for rows, gaps in zip(tracks, near)
    ]
    before = round(LEFT_S * scenario.rate_hz)
    left_over = 0
    for step, rows in enumerate(false):
        since = slice(max(step - before, 0), step)
        past = place[since][there[since]]
        if len(rows) and len(past):
            left_over += int((cdist(rows, past).min(axis=1) < NEAR_M).sum())
    per_minute = 60 / scenario.steps
    return Outcome(
        scores=ground_scores(world, instants),
        feet=np.concatenate([np.empty(0), *_feet(world, there, detections)]),
        delays=_delays(world, there, near),
        entering=_entering(world, there, tracks),
        left_over_s=left_over * per_minute,
        false_s=sum(map(len, false)) * per_minute,
    )


def ground_scores(world: World, instants: Sequence[Tracks]) -> dict[str, float]:
    """Return the scores of all ticks' tracks in the area of the site, at each gate."""
    step, index = np.nonzero(world.active & _inside(world.motion.position))
    truth = Trajectories(step, index + 1, world.motion.position[step, index])
    tracks = Trajectories.from_tracks(instants, *_clock(world))
    tracks = tracks.select(_inside(tracks.position))
    figures = {}
    for gate_m in GATES_M:
        scores = evaluate_ground(truth, tracks, gate_m)
        for name in ('mota', 'idf1', 'precision', 'recall', 'switches'):
            figures[f'{name}_{gate_m:g}m'] = float(getattr(scores, name))
    return figures


def _clock(world: World) -> tuple[int, int]:
    """Return the period and where it begins, ns."""
    period_ns = round(world.scenario.period_s * 1e9)
    return period_ns, world.scenario.stamp_ns(0) - period_ns // 2


def _of_steps(world: World, instants: Sequence[Tracks]) -> list[Floats]:
    """Return the reported tracks inside, (n, 2) m, of each step."""
    period_ns, origin_ns = _clock(world)
    tracks = [np.empty((0, 2)) for _ in range(world.scenario.steps)]
    for rows in instants:
        step = (rows.stamp_ns - origin_ns) // period_ns
        if 0 <= step < len(tracks):
            shown = rows.position[np.isin(rows.status, REPORTED), :2].astype(np.float64)
            tracks[step] = shown[_inside(shown)]
    return tracks


def _feet(
    world: World, there: NDArray[np.bool_], detections: Sequence[Detections]
) -> Iterator[Floats]:
    """Yield the distances of the feet of each message to the nearest person, m."""
    period_ns, origin_ns = _clock(world)
    for rows in detections:
        step = (rows.stamp_ns - origin_ns) // period_ns
        seen = rows.position[np.isfinite(rows.position[:, 0]) & (rows.score > 0), :2]
        if len(seen) and there[step].any():
            gaps = cdist(seen, world.motion.position[step, there[step]]).min(axis=1)
            yield gaps[gaps < FEET_M]


def _delays(world: World, there: NDArray[np.bool_], near: Sequence[Floats]) -> Floats:
    """Return everybody's time from the door to the first track, s."""
    scenario = world.scenario
    first = np.full(there.shape[1], np.inf)
    for step, gaps in enumerate(near):
        person, track = linear_sum_assignment(np.minimum(gaps, NEAR_M))
        found = np.flatnonzero(there[step])[person[gaps[person, track] < NEAR_M]]
        first[found] = np.minimum(first[found], step)
    came = there.any(axis=0)
    return np.asarray((first - there.argmax(axis=0))[came] * scenario.period_s)


def _entering(
    world: World, there: NDArray[np.bool_], tracks: Sequence[Floats]
) -> NDArray[np.float64]:
    """Return the tracks a person of each tick in which a group of two or three enters."""
    group, shares = hall.group_of(world.scenario), []
    after = round(ENTERING_S * world.scenario.rate_hz)
    for each in range(group.max() + 1):
        members = np.flatnonzero((group == each) & there.any(axis=0))
        if len(members) < 2:
            continue
        came = there[:, members].argmax(axis=0)
        for step in range(came.max(), min(came.max() + after, len(tracks))):
            gaps = cdist(tracks[step], world.motion.position[step, there[step]])
            mine = np.isin(np.flatnonzero(there[step]), members)
            near = gaps[:, mine].min(axis=1, initial=np.inf) < NEAR_M
            nearest = mine[gaps.argmin(axis=1)] if gaps.size else near
            if mine.any():
                shares.append(np.count_nonzero(near & nearest) / np.count_nonzero(mine))
    return np.array(shares)


def _inside(place: Floats) -> NDArray[np.bool_]:
    """Return which places lie in the area of the site."""
    area = np.array([hall.LENGTH_M, hall.WIDTH_M])
    return np.asarray(((place >= 0) & (place <= area)).all(axis=-1))
