"""Where every player wants to be: roles, marking, set pieces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.simulation.pitch.field import LENGTH_M, WIDTH_M
from mctrack_ros.simulation.pitch.play import Play, Situation, goal_of
from mctrack_ros.simulation.scenario import Scenario

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

PLAYERS = 25
"""Two teams of 11 and three referees."""

TEAM: Indices = np.repeat([0, 1, 2], [11, 11, 3])
"""Team of each player; 2: referee."""

_FORMATION = np.array(
    [
        *[(5, 34), (22, 12), (22, 26), (22, 42), (22, 56)],
        *[(44, 10), (42, 27), (42, 41), (44, 58), (62, 26), (62, 42)],
    ],
    np.float64,
)
_BALL_PULL = np.array([0.765, 0.65])
_FOLLOW_S = 8.0
_MARK_WITHIN_M, _MARK_AT_M = 20.0, 1.3
_CROWD_M = np.array([3.2, 6.5])
_WALL_M, _WALL_SPACING_M = 9.15, 0.8
_REFEREE_OFF_M = np.array([6.0, 7.0])
_WANDER_M, _WANDER_S = 0.9, 3.0


class Intent:
    """
    The places that players head for.

    Parameters
    ----------
    scenario : Scenario
        Its period.
    play : Play
        The course of the match.
    rng : Generator
        Draws the places of set pieces and the wandering.

    """

    def __init__(self, scenario: Scenario, play: Play, rng: np.random.Generator) -> None:
        self._play, self._rng, self._period = play, rng, scenario.period_s
        mirrored = np.array([LENGTH_M, WIDTH_M]) - _FORMATION
        self._home = np.concatenate([_FORMATION, mirrored])
        self._focus = play.ball[0]
        self._slots = rng.uniform(-1, 1, (PLAYERS, 2))
        self._wander = rng.normal(scale=_WANDER_M, size=(PLAYERS, 2))

    def start(self) -> Floats:
        """Return the (n, 2) places at kick-off."""
        return self._with_referees(self._home.copy(), self._play.ball[0]) + self._wander

    def targets(self, step: int, position: Floats) -> Floats:
        """Return the (n, 2) places wanted at a step, given the (n, 2) positions, m."""
        self._stroll()
        ball = self._play.ball[step]
        self._focus = self._focus + (ball - self._focus) * self._period / _FOLLOW_S
        places = self._home + _BALL_PULL * (self._focus - self._home)
        for team in (0, 1):
            places[11 * team] = goal_of(team) + 0.08 * (ball - goal_of(team))
        situation = Situation(self._play.situation[step])
        attackers = int(self._play.attackers[step])
        if situation == Situation.OPEN_PLAY:
            self._play_on(places, ball, attackers, position)
        else:
            self._set_piece(places, situation, attackers, self._play.spot[step])
        wander = self._wander * (1.0 if situation == Situation.OPEN_PLAY else 0.25)
        wanted = self._with_referees(places, self._focus) + wander
        return np.clip(wanted, [0.5, 0.5], [LENGTH_M - 0.5, WIDTH_M - 0.5])

    def _stroll(self) -> None:
        """Let everybody wander a little from where they want to be."""
        keep = np.exp(-self._period / _WANDER_S)
        kick = self._rng.normal(scale=_WANDER_M * np.sqrt(1 - keep**2), size=(PLAYERS, 2))
        self._wander = keep * self._wander + kick

    def _play_on(self, places: Floats, ball: Floats, attackers: int, position: Floats) -> None:
        """Let the nearest chase the ball and the defending team mark."""
        marking = _field(1 - attackers)
        opponents = _field(attackers)
        apart = np.linalg.norm(places[marking][:, None] - position[opponents][None], axis=2)
        marker, marked = linear_sum_assignment(apart)
        opponent = position[opponents[marked]]
        goal_side = goal_of(1 - attackers) - opponent
        goal_side /= np.linalg.norm(goal_side, axis=1, keepdims=True)
        marks = apart[marker, marked] < _MARK_WITHIN_M
        places[marking[marker[marks]]] = (opponent + _MARK_AT_M * goal_side)[marks]
        for team, count in ((attackers, 1), (1 - attackers, 2)):
            field = _field(team)
            distance = np.linalg.norm(position[field] - ball, axis=1)
            chasers = field[np.argsort(distance, kind='stable')[:count]]
            places[chasers] = ball + 0.6 * self._slots[chasers]

    def _set_piece(
        self, places: Floats, situation: Situation, attackers: int, spot: Floats
    ) -> None:
        """Crowd before the goal, build a wall, or celebrate."""
        goal = goal_of(1 - attackers)
        attack, defence = _field(attackers), _field(1 - attackers)
        inward = np.array([1.0 if goal[0] == 0 else -1.0, 0.0])
        if situation == Situation.CELEBRATION:
            happy = attack[3:]
            places[happy] = spot + 1.1 * self._slots[happy]
            return
        depth = 7.5 if situation == Situation.CORNER else 14.0
        crowd = attack[3:9]
        places[crowd] = goal + depth * inward + self._slots[crowd] * _CROWD_M
        guards = defence[:6]
        places[guards] = places[crowd] - _MARK_AT_M * inward
        places[attack[9]] = spot
        if situation == Situation.FREE_KICK:
            places[defence[6:]] = self._wall(spot, goal, len(defence[6:]))

    def _wall(self, spot: Floats, goal: Floats, count: int) -> Floats:
        """Return places side by side between the ball and the goal."""
        towards = (goal - spot) / np.linalg.norm(goal - spot)
        along = np.array([-towards[1], towards[0]])
        offsets = (np.arange(count) - (count - 1) / 2) * _WALL_SPACING_M
        return np.asarray(spot + _WALL_M * towards + offsets[:, None] * along)

    def _with_referees(self, places: Floats, ball: Floats) -> Floats:
        """Append the referee near the ball and his assistants on the touch lines."""
        half = LENGTH_M / 2
        referees = [
            ball + _REFEREE_OFF_M * np.where(ball > [half, WIDTH_M / 2], -1, 1),
            (np.clip(ball[0], 15, half), 0.3),
            (np.clip(ball[0], half, LENGTH_M - 15), WIDTH_M - 0.3),
        ]
        return np.concatenate([places, referees])


def _field(team: int) -> Indices:
    """Return the indices of a team's ten field players."""
    return np.arange(1, 11) + 11 * team
