"""The particle filter with joint state estimation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.papers.covering.targets import Roster, Sight, beginnings
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.association.config import JointAssociationConfig
from mctrack_ros.fusion.motion.models import INITIAL_SPEED_SIGMA
from mctrack_ros.tracking.kalman import inverse
from mctrack_ros.tracking.particles import moved, systematic_rows

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

PARTICLES = 200
DETECTED = 0.9
"""Probability that a target in view is detected."""
LEAST = 0.5
"""Share of a detection from which it supports a target."""


class JointParticleTracker:
    """
    Particles that hold the states of all targets at once.

    In each particle the targets compete for the detections: one that another target explains
    counts the less for this one. The states of a target are then drawn anew among the particles
    by its own part of the weight (independent partitions, Orton and Fitzgerald 2002, "A Bayesian
    approach to tracking multiple targets using sensor arrays and particle filters"), without which
    so few particles would not do for more than three targets. Targets move by white acceleration.

    Parameters
    ----------
    config : JointConfig
        Its motion, its times and its density of false detections.
    seed : int
        Of all that is drawn.

    """

    def __init__(self, config: JointConfig, seed: int = 1) -> None:
        self._config, self._rng = config, np.random.default_rng(seed)
        assert isinstance(config.association, JointAssociationConfig)
        self._false_density = config.association.false_density
        self._roster = Roster(config.management)
        self._state = np.empty((PARTICLES, 0, 4))

    def step(self, sight: Sight, seconds: float) -> tuple[Indices, Floats]:
        """Return the ids (n,) and places (n, 2), m, of those it stands for."""
        self._move(seconds)
        place = self._state[..., :2].mean(axis=0)
        if len(self._roster) and len(sight.position):
            place = self._weigh(sight, seconds)
        else:
            self._roster.count(np.zeros((len(place), len(sight.position))), sight, LEAST, seconds)
        stays = self._roster.staying(place, seconds)
        self._state, place = self._state[:, stays], place[stays]
        reported = self._roster.is_told
        ids, places = self._roster.id[reported], place[reported]
        self._begin(sight, place)
        return ids, places

    def _move(self, seconds: float) -> None:
        noise = self._rng.normal(size=(2, *self._state[..., :2].shape))
        self._state[..., :2], self._state[..., 2:] = moved(
            self._state[..., :2],
            self._state[..., 2:],
            seconds,
            self._config.motion.acceleration_density,
            noise,
        )

    def _weigh(self, sight: Sight, seconds: float) -> Floats:
        """Draw every target's states anew; return the (n, 2) mean places before that."""
        false = self._false_density
        fit = _densities(self._state[..., :2], sight) * self._roster.alike(sight)
        ratio = DETECTED / (1 - DETECTED) * fit / false
        share = ratio / (1.0 + ratio.sum(axis=1, keepdims=True) - ratio)
        weight = np.ones(share.shape[:2])
        for image in np.unique(sight.image):
            weight *= 1.0 + share[..., sight.image == image].sum(axis=2)
        weight /= weight.sum(axis=0)
        place = np.einsum('pn,pnx->nx', weight, self._state[..., :2])
        taken = ratio / (1.0 + ratio.sum(axis=1, keepdims=True))
        self._roster.count(np.einsum('pn,pnm->nm', weight, taken), sight, LEAST, seconds)
        self._state = self._drawn(weight)
        return np.asarray(place)

    def _drawn(self, weight: Floats) -> Floats:
        """Return the states, each target's drawn systematically by its (particles, n) weights."""
        state = np.empty_like(self._state)
        offset = self._rng.random()
        for target in range(state.shape[1]):
            rows = self._rng.permutation(systematic_rows(weight[:, target], offset))
            state[:, target] = self._state[rows, target]
        return state

    def _begin(self, sight: Sight, place: Floats) -> None:
        rows = beginnings(sight, place)
        self._roster.begin(len(rows))
        fresh = self._rng.normal(size=(PARTICLES, len(rows), 4))
        spread = np.linalg.cholesky(sight.noise[rows])
        fresh[..., :2] = sight.position[rows] + np.einsum('nij,pnj->pni', spread, fresh[..., :2])
        fresh[..., 2:] *= INITIAL_SPEED_SIGMA
        self._state = np.append(self._state, fresh, axis=1)


def _densities(place: Floats, sight: Sight) -> Floats:
    """Return the densities (particles, n, m), 1/m², of detections where targets are."""
    information = inverse(sight.noise)
    x, y = np.moveaxis(place[:, :, None] - sight.position, 3, 0)
    squared = information[:, 0, 0] * x**2 + 2 * information[:, 0, 1] * x * y
    squared += information[:, 1, 1] * y**2
    scale = np.sqrt(np.linalg.det(information)) / (2 * np.pi)
    return np.asarray(scale * np.exp(-squared / 2))
