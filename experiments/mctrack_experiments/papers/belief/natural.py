"""Occlusions as they happen when real players' paths drive the simulator."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.datasets.kloppy_motion import Sample, real_world
from mctrack_experiments.papers.belief.scenes import (
    HIDDEN_BELOW,
    Kind,
    Occlusion,
    OcclusionScene,
    visible_shares,
)
from mctrack_ros.simulation import LENGTH_M, WIDTH_M, Scenario, World, placed
from mctrack_ros.simulation.pitch.intent import TEAM

Floats = NDArray[np.float64]

SECONDS = 55.0
TURNS = ((False, False), (True, False), (False, True), (True, True))
"""Whether the paths are mirrored along and across the pitch, before the same two cameras."""
AROUND_S = 1.2
"""For so long before and after an occlusion the player is in both views, s."""
SHORTEST_STEPS = 3
_REFEREES = 2


def natural(turn: tuple[bool, bool]) -> OcclusionScene:
    """
    Return the scene of Hawk-Eye's sample before two static cameras, its paths mirrored.

    Its occlusions are those of at least `SHORTEST_STEPS` images, of players who are in both views
    from `AROUND_S` before, and not hidden then, to `AROUND_S` after; nothing is scripted.

    Raises
    ------
    ImportError
        If kloppy is not installed.

    """
    scenario = Scenario(seed=1, duration_s=SECONDS, rate_hz=25.0, cameras=2)
    world = _turned(real_world(scenario, Sample.HAWKEYE), turn)
    players = np.flatnonzero(TEAM != _REFEREES)
    found = list(_occlusions(world, players, visible_shares(world, players)))
    persons = sorted({int(players[player]) for player, *_ in found})
    occlusions = [
        Occlusion(
            Kind.ONE_VIEW if len(cameras) == 1 else Kind.BOTH_VIEWS,
            persons.index(int(players[player])),
            (first + last) / 2 * scenario.period_s,
            cameras,
        )
        for player, first, last, cameras in found
    ]
    occlusions.sort(key=lambda each: each.centre_s)
    return OcclusionScene(world, tuple(persons), tuple(occlusions))


def _turned(world: World, turn: tuple[bool, bool]) -> World:
    place = world.motion.position.copy()
    for axis, size in enumerate((LENGTH_M, WIDTH_M)):
        if turn[axis]:
            place[..., axis] = size - place[..., axis]
    return placed(world.scenario, place, world.active)


def _occlusions(
    world: World, players: NDArray[np.int64], visible: Floats
) -> Iterator[tuple[int, int, int, tuple[int, ...]]]:
    """Yield player, first step, that after the last, and in which cameras he was hidden."""
    around = round(AROUND_S * world.scenario.rate_hz)
    in_view = world.feet_in_view[:, :, players]
    seen = in_view.all(axis=1) & world.active[:, players]
    hidden = (visible < HIDDEN_BELOW) & in_view
    for player in range(len(players)):
        edges = np.flatnonzero(
            np.diff(hidden[:, :, player].any(axis=1), prepend=False, append=False)
        )
        for first, last in edges.reshape(-1, 2).tolist():
            begin, end = first - around, last + around
            if begin < 0 or end > len(seen) or not seen[begin:end, player].all():
                continue
            during = hidden[first:last, :, player]
            if last - first >= SHORTEST_STEPS and not hidden[begin:first, :, player].any():
                yield player, first, last, tuple(np.flatnonzero(during.any(axis=0)).tolist())
