"""A ghost, and cameras that see what they are told: nothing confirms itself by feedback."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.scenarios.rooms import AROUND, PERSONAL, TWO_TEAMS, turned
from mctrack_experiments.scenarios.staged.playing import Played, play
from mctrack_experiments.scenarios.staged.stage import (
    TICK_S,
    Stage,
    foot_covariance,
    hidden_in,
)
from mctrack_experiments.scenarios.staged.walks import walk
from mctrack_ros.interfaces import CameraDetections, Detections, Feedback

Floats = NDArray[np.float64]

SECONDS, BEGINS_S = 10.0, 4.0
LASTS_S = 2.0
DIES_WITHIN_S = 1.0
NEAR_M = 2.0
GHOST_ID = 900_000

GHOSTS = {'told': 0, 'one_camera': 1, 'two_cameras': 2}
"""How many cameras see it: none, feedback alone tells of it; one; two, at the same place."""

CREDULITY = {'': 0.0, '_credulous': 0.02}
"""Probability that a camera detects in an image, in noise, one whom feedback tells of."""


@dataclass(slots=True)
class Haunting:
    """
    A row of feedback that stands for nobody, and cameras that find in noise what they are told.

    Attributes
    ----------
    place : (2,) array
        Of the ghost, m.
    is_told : bool
        Whether feedback tells of it though fusion has no track there.
    credulity : float
        Probability of a detection in noise.
    rng : Generator
        Of the noise.

    """

    place: Floats
    is_told: bool
    credulity: float
    rng: np.random.Generator

    def told(self, tick: int, feedback: Feedback) -> Feedback:
        """Return feedback with the ghost in it, in its time."""
        if not self.is_told or not BEGINS_S <= tick * TICK_S < BEGINS_S + LASTS_S:
            return feedback
        ghost = Feedback.build(
            feedback.stamp_ns,
            position=[[*self.place, 0.0]],
            covariance=[np.diag([0.1, 0.1, 0.5, 0.5])],
            track_id=[GHOST_ID],
        )
        return Feedback.joined(feedback.stamp_ns, [feedback, ghost])

    def seen(
        self, messages: Sequence[CameraDetections], feedback: Feedback
    ) -> list[CameraDetections]:
        """Return what cameras see and what, of those told of near the ghost, they imagine."""
        return [
            replace(one, rows=self._imagined(one.rows, np.array(view.position), feedback))
            for one, view in zip(messages, AROUND)
        ]

    def _imagined(self, rows: Detections, camera: Floats, feedback: Feedback) -> Detections:
        places = feedback.places(rows.stamp_ns)
        near = np.linalg.norm(places - self.place, axis=1) < NEAR_M
        near &= self.rng.random(len(places)) < self.credulity
        count = int(near.sum())
        spread = foot_covariance(places[near], camera)
        noise = np.linalg.cholesky(spread) @ self.rng.normal(size=(count, 2, 1))
        imagined = Detections.build(
            rows.stamp_ns,
            position=np.column_stack([places[near] + noise[:, :, 0], np.zeros(count)]),
            covariance=spread,
            track_id=feedback.track_id[near],
        )
        return Detections.joined(rows.stamp_ns, [rows, imagined])


def ghost(seed: int, kind: str, credulity: str) -> dict[str, bool]:
    """
    Play one scene: two people walk, and something is not there.

    Parameters
    ----------
    seed : int
        Of all that is left to chance.
    kind : str
        Of `GHOSTS`.
    credulity : str
        Of `CREDULITY`.

    Returns
    -------
    dict of str to bool
        ``dies``: it is reported no later than a second after its last cause; ``never``: it is
        not reported at all.

    """
    rng = np.random.default_rng([seed, 1])
    place = rng.uniform(-3.0, 3.0, 2)
    ghosts = np.tile(place, (round(SECONDS / TICK_S), 1, 1))
    paths = np.concatenate([_people(rng), ghosts], axis=1)
    hidden = hidden_in(paths, (), len(AROUND))
    begins, ends = round(BEGINS_S / TICK_S), round((BEGINS_S + LASTS_S) / TICK_S)
    liars = rng.permutation(len(AROUND))[: GHOSTS[kind]]
    hidden[:, -1] = True
    hidden[begins:ends, -1, liars] = False
    stage = Stage(paths, np.append(TWO_TEAMS[:2], 0), AROUND, hidden, PERSONAL)
    haunting = Haunting(place, kind == 'told', CREDULITY[credulity], rng)
    seconds = reported_s(play(stage, seed, haunting=haunting), place)
    last_s = max(seconds, default=0.0)
    return {'dies': last_s <= BEGINS_S + LASTS_S + DIES_WITHIN_S, 'never': not len(seconds)}


def reported_s(played: Played, place: Floats) -> Sequence[float]:
    """Return the times at which somebody is reported near a place, s."""
    return [
        tick * TICK_S
        for tick in range(round(BEGINS_S / TICK_S), len(played.paths))
        if (np.linalg.norm(played.reported(tick)[1] - place, axis=1) < NEAR_M).any()
    ]


def _people(rng: np.random.Generator) -> Floats:
    """Return the (ticks, 2, 2) paths of two who walk past, far from the middle."""
    angle = rng.uniform(0, 2 * np.pi)
    paths = [
        walk([(0.0, -6.0, y), (SECONDS, 6.0, y)], SECONDS, rng) for y in rng.uniform(6.5, 8.0, 2)
    ]
    return turned(np.stack(paths, axis=1), angle)
