"""Whether tracks are as wrong as they say: NEES against its band, and the map of errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from mctrack_experiments.bench.workers import run_spread
from mctrack_experiments.scenarios.rooms import AROUND, HALL, PERSONAL
from mctrack_experiments.scenarios.staged.playing import GATE_M, Played, play
from mctrack_experiments.scenarios.staged.stage import TICK_S, Stage, View, hidden_in
from mctrack_experiments.scenarios.staged.walks import walk
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.evaluation.frames import ground_distance, matched
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.motion.config import MOTION
from mctrack_ros.fusion.motion.models import MODELS
from mctrack_ros.interfaces import TrackStatus
from mctrack_ros.simulation import Scenario
from mctrack_ros.simulation.pitch.players import simulate_motion

Floats = NDArray[np.float64]

SECONDS, SETTLED_S = 8.0, 2.0
WIDE = (-45.0, -45.0, 45.0, 45.0)
FAR = tuple(View(place, WIDE) for place in ((-50.0, -40.0), (50.0, -40.0), (0.0, 60.0)))
PITCH = (-10.0, -10.0, 115.0, 78.0)
STANDS = tuple(View(place, PITCH) for place in ((-15.0, -15.0), (120.0, -15.0), (52.5, 90.0)))
CELL_M = 5.0
LEAST_ROWS = 200
"""A cell of the map with fewer rows is left out."""
STATE, PLACE = 4, 2

Rows = tuple[Floats, Floats, Floats]
"""Per tick and track: the true state (n, 4), the error (n, 4), the covariance (n, 4, 4)."""


def reproduce_consistency(
    seeds: Sequence[int], progress: Callable[[int, int], None] = lambda done, total: None
) -> Figures:
    """
    Hold tracks' errors against their covariances.

    Parameters
    ----------
    seeds : sequence of int
        One target that moves as the filter assumes, one who walks and one who plays, for each.
    progress : callable
        Told how many are done, of how many.

    """
    jobs = [(kind, model, seed) for kind, model in RUNS for seed in seeds]
    rows = run_spread(_rows, jobs, progress)
    figures: dict[str, float] = {}
    for index, (kind, model) in enumerate(RUNS):
        runs = rows[index * len(seeds) : (index + 1) * len(seeds)]
        name = kind if model == JointConfig().motion.model else f'{kind}.{model}'
        figures |= nees_figures(name, runs, STATE) | nees_figures(f'{name}.place', runs, PLACE)
        figures |= error_figures(name, runs)
        if kind in MAPPED:
            figures |= map_figures(name, runs)
    return Figures('consistency', 'mctrack reproduce consistency', _protocol(seeds), figures)


def nees_figures(name: str, runs: Sequence[Rows], size: int) -> dict[str, float]:
    """
    Return the NEES of the first values of the state, per value, and how it lies in its band.

    A tick's mean over independent runs is chi-square distributed over them (Bar-Shalom, Li and
    Kirubarajan 2001, section 5.4.2).
    """
    whole = min(len(error) for _, error, _ in runs)
    squared = np.array([_normalised(error, spread, size)[-whole:] for _, error, spread in runs])
    freedom = size * len(runs)
    low, high = chi2.ppf([0.025, 0.975], freedom) / freedom
    mean = squared.mean(axis=0) / size
    return {
        f'{name}.nees': float(mean.mean()),
        f'{name}.nees_low': float(low),
        f'{name}.nees_high': float(high),
        f'{name}.nees_inside': float(((mean >= low) & (mean <= high)).mean()),
    }


def error_figures(name: str, runs: Sequence[Rows]) -> dict[str, float]:
    """Return the rms errors of places, m, and velocities, m/s, measured over what is told."""
    _, error, spread = (np.concatenate(each) for each in zip(*runs))
    measured, told = error**2, np.diagonal(spread, axis1=1, axis2=2)
    figures = {}
    for word, part in (('error_m', slice(2)), ('velocity_error', slice(2, 4))):
        rms = np.sqrt(measured[:, part].sum(axis=1).mean())
        figures[f'{name}.{word}'] = float(rms)
        figures[f'{name}.{word}_ratio'] = float(rms / np.sqrt(told[:, part].sum(axis=1).mean()))
    return figures


def map_figures(name: str, runs: Sequence[Rows]) -> dict[str, float]:
    """Return how measured and predicted rms errors of places agree, cell by cell."""
    truth, error, spread = (np.concatenate(each) for each in zip(*runs))
    cell = np.unique(np.floor(truth[:, :2] / CELL_M), axis=0, return_inverse=True)[1].ravel()
    count = np.bincount(cell)
    measured = np.bincount(cell, (error[:, :2] ** 2).sum(axis=1))
    predicted = np.bincount(cell, np.trace(spread[:, :2, :2], axis1=1, axis2=2))
    enough = count >= LEAST_ROWS
    ratio = np.sqrt(measured[enough] / predicted[enough])
    return {
        f'{name}.map.cells': int(enough.sum()),
        f'{name}.map.ratio': float(np.sqrt(measured.sum() / predicted.sum())),
        f'{name}.map.difference': float(np.median(np.abs(ratio - 1))),
        f'{name}.map.within_25': float((np.abs(ratio - 1) <= 0.25).mean()),
    }


def _normalised(error: Floats, spread: Floats, size: int) -> Floats:
    """Return the squared errors in units of their covariances, (n,)."""
    error, spread = error[:, :size], spread[:, :size, :size]
    solved = np.linalg.solve(spread, error[:, :, None])[:, :, 0]
    return np.asarray((error * solved).sum(axis=1))


def modelled(seed: int, config: JointConfig) -> Rows:
    """Play one who moves as the filter assumes, seen with the errors that it is told of."""
    rng = np.random.default_rng([seed, 1])
    density = config.motion.acceleration_density
    states = np.zeros((round(SECONDS / TICK_S), 4))
    cube, square = TICK_S**3 / 3, TICK_S**2 / 2
    noise = np.linalg.cholesky(density * np.array([[cube, square], [square, TICK_S]]))
    for last, state in pairwise(states):
        state[:2], state[2:] = last[:2] + TICK_S * last[2:], last[2:]
        state += (noise @ rng.normal(size=(2, 2))).ravel()
    error_m = config.motion.sensor_sigma
    paths = states[:, None, :2]
    hidden = hidden_in(paths, (), len(FAR))
    stage = Stage(paths, np.zeros(1, np.int64), FAR, hidden, PERSONAL, 0.0, error_m)
    return rows_of(play(stage, seed, config), states)


def walking(seed: int, config: JointConfig) -> Rows:
    """Play one who walks through the hall before cameras that are each a little off."""
    rng = np.random.default_rng([seed, 1])
    places = rng.uniform(HALL[0] + 2, HALL[2] - 2, (4, 2))
    legs = np.linalg.norm(np.diff(places, axis=0), axis=1) / rng.uniform(1.1, 1.6)
    times = np.concatenate([[0.0], np.cumsum(legs)])
    path = walk(np.column_stack([times, places]).tolist(), float(times[-1]), rng)
    paths = path[:, None]
    stage = Stage(paths, np.zeros(1, np.int64), AROUND, hidden_in(paths, (), 3), PERSONAL)
    states = np.column_stack([path, np.gradient(path, TICK_S, axis=0)])
    return rows_of(play(stage, seed, config), states)


def playing(seed: int, config: JointConfig) -> Rows:
    """Play one player of the synthetic match, who runs, brakes and turns, before such cameras."""
    motion = simulate_motion(Scenario(seed=seed, duration_s=SECONDS))
    player = seed % motion.position.shape[1]
    paths = motion.position[:, [player]]
    hidden = hidden_in(paths, (), len(STANDS))
    stage = Stage(paths, np.zeros(1, np.int64), STANDS, hidden, PERSONAL)
    return rows_of(
        play(stage, seed, config), np.column_stack([paths[:, 0], motion.velocity[:, player]])
    )


KINDS = {'model': modelled, 'walking': walking, 'playing': playing}
MAPPED = ('walking', 'playing')
RUNS = (('model', 'constant_velocity'), *((kind, model) for kind in MAPPED for model in MODELS))
"""Who moves how, and how fusion thinks that he does."""


def rows_of(played: Played, states: Floats) -> Rows:
    """Return what is told of one target once it is settled, tick by tick, beside its states."""
    found: list[Rows] = []
    for tick in range(round(SETTLED_S / TICK_S), len(states)):
        tracks = played.outputs[tick].tracks
        tracks = tracks.select(tracks.status == TrackStatus.CONFIRMED)
        places = tracks.position[:, :2].astype(np.float64)
        _, rows = matched(ground_distance(states[[tick], :2], places), GATE_M)
        told = np.column_stack([places, tracks.velocity])[rows]
        spread = tracks.covariance[rows].astype(np.float64)
        found.append((states[[tick]][: len(rows)], told - states[tick], spread))
    truth, error, spread = (np.concatenate(each) for each in zip(*found))
    return truth, error, spread


def _rows(job: tuple[str, str, int]) -> Rows:
    kind, model, seed = job
    config = JointConfig()
    return KINDS[kind](seed, replace(config, motion=MOTION.made(model)))


def _protocol(seeds: Sequence[int]) -> dict[str, str]:
    return {
        'scenes': 'detections on the ground, 25 ticks a second, three cameras; fusion as it comes',
        'seeds': f'{min(seeds)} to {max(seeds)}; nothing is tuned',
        'model': "one target whose acceleration is white noise of the filter's density, errors of "
        'detections as the filter is told; cameras 40 to 100 m away',
        'walking': 'one who walks straight from place to place and sways, cameras 0.1 m off each',
        'playing': 'one player of the synthetic match, cameras so, around the pitch',
        'interacting': 'with motion.model interacting',
        'error': 'rms of places and of velocities (m/s); ratio: over what is told',
        'nees': 'normalised estimation error squared per value of the state (place and velocity; '
        f'place alone), from {SETTLED_S:g} s on: 1 is right, below it the tracks are better '
        'than they say; low, high: 95 % band of its mean over the seeds at a tick; inside: share '
        'of the ticks in the band, .95 if all is right',
        'map': f'cells of {CELL_M:g} m with at least {LEAST_ROWS} rows; ratio: measured over '
        'predicted rms error of all; difference: median over cells of how far that is from 1',
    }
