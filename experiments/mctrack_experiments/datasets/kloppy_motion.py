"""Real players' paths that drive the simulator: the tracking samples in kloppy's wheel."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from importlib.resources import files
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation import LENGTH_M, WIDTH_M, Scenario, World, placed
from mctrack_ros.simulation.pitch.intent import PLAYERS

Floats = NDArray[np.float64]

MISSING = "kloppy is not installed: pip install 'mctrack_experiments[motion]'"
TEAM_SIZE = 11
LONGEST_GAP_S = 0.5
"""A player without samples for longer is not on the pitch."""
FASTEST_MPS = 12.0
"""Nor is one whom the samples move faster: television's jump to another place."""


class Sample(StrEnum):
    """A real recording."""

    HAWKEYE = 'hawkeye'
    SKILLCORNER = 'skillcorner'


def has_kloppy() -> bool:
    """Return whether the samples are there."""
    return find_spec('kloppy') is not None


def real_world(scenario: Scenario, sample: Sample, start_s: float = 0.0) -> World:
    """
    Return the world in which players move as they did in a real match.

    Samples are joined by straight lines and read off at the cameras' rate. Metres are kept, the
    middle of the real pitch is laid on that of the simulated one. There are no referees.

    Parameters
    ----------
    scenario : Scenario
        Of static or PTZ cameras; its length and rate.
    sample : Sample
        Hawk-Eye: 60 s at 50 Hz; SkillCorner: a half at 10 Hz from television, and nobody
        while it shows something else.
    start_s : float
        Where in the sample to begin, s after its first players.

    Raises
    ------
    ImportError
        If kloppy is not installed; says how.
    ValueError
        If the sample ends before the scenario.

    """
    if not has_kloppy():
        raise ImportError(MISSING)
    end_s = start_s + scenario.duration_s
    times, teams = _paths(_LOADERS[sample](), end_s)
    if not times or max(times) < end_s - LONGEST_GAP_S:
        last = max(times, default=0.0)
        raise ValueError(f'{sample} ends after {last:.1f} s, expected {end_s:.1f} s')
    steps = np.arange(scenario.steps, dtype=np.float64)
    clock = np.asarray(start_s + (steps + 0.5) * scenario.period_s, np.float64)
    position = np.zeros((scenario.steps, PLAYERS, 2))
    active = np.zeros((scenario.steps, PLAYERS), np.bool_)
    for team, paths in enumerate(teams.values()):
        longest = sorted(paths.values(), key=lambda path: _time_within(path, start_s))
        for player, path in enumerate(longest[:TEAM_SIZE]):
            person = TEAM_SIZE * team + player
            position[:, person], active[:, person] = _read_off(np.array(path, np.float64), clock)
    if scenario.steps > 1:
        velocity = np.gradient(position, scenario.period_s, axis=0)
        active &= np.linalg.norm(velocity, axis=2) <= FASTEST_MPS
    return placed(scenario, position, active)


Path = list[tuple[float, float, float]]


def _time_within(path: Path, start_s: float) -> int:
    """Return minus the number of samples from a time on: the most present come first."""
    return -sum(time >= start_s for time, _, _ in path)


def _paths(dataset: Any, end_s: float) -> tuple[list[float], dict[str, dict[str, Path]]]:
    """Return the times of the samples, s, and each team's players' times and places, s and m."""
    times: list[float] = []
    teams: dict[str, dict[str, Path]] = {'home': {}, 'away': {}}
    first = None
    for record in dataset.records:
        if not record.players_data:
            continue
        first = record.timestamp if first is None else first
        time = (record.timestamp - first).total_seconds()
        if time < 0:
            break
        times.append(time)
        if time > end_s + LONGEST_GAP_S:
            break
        for player, data in record.players_data.items():
            team = teams.get(str(player.team.ground)) if player.team else None
            if team is not None and data.coordinates is not None:
                x, y = data.coordinates.x + LENGTH_M / 2, data.coordinates.y + WIDTH_M / 2
                team.setdefault(player.player_id, []).append((time, x, y))
    return times, teams


def _read_off(path: Floats, clock: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return places at times, (steps, 2) m, and whether the player was there, (steps,)."""
    times = path[:, 0]
    places = np.stack([np.interp(clock, times, path[:, axis]) for axis in (1, 2)], axis=1)
    after = np.searchsorted(times, clock)
    before = np.clip(after - 1, 0, len(times) - 1)
    after = np.clip(after, 0, len(times) - 1)
    gap = np.maximum(times[after], clock) - np.minimum(times[before], clock)
    return places, gap <= LONGEST_GAP_S


def _hawkeye() -> Any:
    from kloppy import hawkeye

    folder = files('kloppy') / 'tests' / 'files'
    return hawkeye.load(
        ball_feeds=str(folder / 'hawkeye_1_1.football.samples.ball'),
        player_centroid_feeds=str(folder / 'hawkeye_1_1.football.samples.centroids'),
        meta_data=str(folder / 'hawkeye_meta.json'),
        coordinates='hawkeye',
    )


def _skillcorner() -> Any:
    from kloppy import skillcorner

    folder = files('kloppy') / 'tests' / 'files'
    return skillcorner.load(
        meta_data=str(folder / 'skillcorner_match_data.json'),
        raw_data=str(folder / 'skillcorner_structured_data.json'),
        coordinates='skillcorner',
        include_empty_frames=False,
    )


_LOADERS: dict[Sample, Callable[[], Any]] = {
    Sample.HAWKEYE: _hawkeye,
    Sample.SKILLCORNER: _skillcorner,
}
