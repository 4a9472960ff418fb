"""The course of a match: where the ball is, and which set piece is being played."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.simulation.pitch.field import CENTRE_M, LENGTH_M, WIDTH_M
from mctrack_ros.simulation.scenario import Scenario

Floats = NDArray[np.float64]

_OPEN_PLAY_S = (6.0, 10.0)
_SET_PIECE_S = (13.0, 19.0)
_PASS_S = (2.5, 5.0)
_PASS_LENGTH_M = 8.0
_TURNOVER = 0.3


class Situation(IntEnum):
    """What is going on."""

    OPEN_PLAY = 0
    CORNER = 1
    FREE_KICK = 2
    CELEBRATION = 3


_SET_PIECES = (
    Situation.CORNER,
    Situation.FREE_KICK,
    Situation.CORNER,
    Situation.CELEBRATION,
)


@dataclass(frozen=True, eq=False, slots=True)
class Play:
    """
    The course of a match, one row a step.

    Attributes
    ----------
    ball : (steps, 2) array
        The ball, m.
    situation : (steps,) int array
        A `Situation`.
    attackers : (steps,) int array
        The team that has the ball, 0 or 1; team 0 plays towards larger x.
    spot : (steps, 2) array
        Where the set piece is taken, m; in open play the ball.

    """

    ball: Floats
    situation: NDArray[np.int64]
    attackers: NDArray[np.int64]
    spot: Floats


def course_of_play(scenario: Scenario, rng: np.random.Generator) -> Play:
    """Draw open play and set pieces in turn until the time is over."""
    times, places = [0.0], [CENTRE_M]
    phases: list[tuple[float, Situation, int, Floats]] = []
    clock, turn, attackers = 0.0, int(rng.integers(4)), int(rng.integers(2))
    while clock < scenario.duration_s:
        attackers = 1 - attackers if rng.random() < _TURNOVER else attackers
        phases.append((clock, Situation.OPEN_PLAY, attackers, places[-1]))
        clock = _pass_around(times, places, clock + rng.uniform(*_OPEN_PLAY_S), attackers, rng)
        situation, turn = _SET_PIECES[turn % 4], turn + 1
        spot = _set_piece_spot(situation, attackers, rng)
        phases.append((clock, situation, attackers, spot))
        times.extend([clock + 1.5, clock + rng.uniform(*_SET_PIECE_S)])
        places.extend([spot, spot])
        clock = times[-1]
    return _sampled(scenario, np.array(times), np.array(places), phases)


def goal_of(team: int) -> Floats:
    """Return the middle of the goal that a team defends, (2,) m."""
    return np.array([0.0 if team == 0 else LENGTH_M, WIDTH_M / 2])


def _pass_around(
    times: list[float],
    places: list[Floats],
    until: float,
    attackers: int,
    rng: np.random.Generator,
) -> float:
    """Append passes that drift towards the attacked goal; return when the last arrives."""
    while times[-1] < until:
        drift = 0.15 * (goal_of(1 - attackers) - places[-1])
        place = places[-1] + drift + rng.normal(scale=_PASS_LENGTH_M, size=2)
        places.append(np.clip(place, [2.0, 2.0], [LENGTH_M - 2, WIDTH_M - 2]))
        times.append(times[-1] + rng.uniform(*_PASS_S))
    return times[-1]


def _set_piece_spot(situation: Situation, attackers: int, rng: np.random.Generator) -> Floats:
    """Return where a set piece is taken: a corner, before the goal, or anywhere."""
    goal = goal_of(1 - attackers)
    inward = 1.0 if goal[0] == 0 else -1.0
    if situation == Situation.CORNER:
        return np.array([goal[0], WIDTH_M * rng.integers(2)])
    if situation == Situation.FREE_KICK:
        depth, across = rng.uniform(20, 30), rng.uniform(-18, 18)
    else:
        depth, across = rng.uniform(8, 25), rng.uniform(-25, 25)
    return np.array([goal[0] + inward * depth, goal[1] + across])


def _sampled(
    scenario: Scenario,
    times: Floats,
    places: Floats,
    phases: list[tuple[float, Situation, int, Floats]],
) -> Play:
    """Read the course off at every step."""
    clock = (np.arange(scenario.steps) + 0.5) * scenario.period_s
    ball = np.stack([np.interp(clock, times, places[:, axis]) for axis in (0, 1)], axis=1)
    phase = np.searchsorted([start for start, *_ in phases], clock, side='right') - 1
    situation = np.array([kind for _, kind, *_ in phases], np.int64)[phase]
    attackers = np.array([team for _, _, team, _ in phases], np.int64)[phase]
    spots = np.array([spot for *_, spot in phases])[phase]
    spot = np.where((situation == Situation.OPEN_PLAY)[:, None], ball, spots)
    return Play(ball, situation, attackers, spot)
