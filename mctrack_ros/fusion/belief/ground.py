"""The ground node: particles of every target, and the messages of a tick."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.messages import Round, ViewSamples, propagate
from mctrack_ros.interfaces import Belief
from mctrack_ros.interfaces.belief import HIDDEN
from mctrack_ros.tracking.particles import (
    effective_size,
    log_mixture,
    moved,
    stream,
    systematic_rows,
    whitened,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

ACCELERATION = 2.0
"""Density of the acceleration of people, m²/s³; `fusion.motion.acceleration_density`."""
USUAL_EXTENT = (1.75, 0.55)
"""Height and width of a person, m."""
EXTENT_SIGMA = (0.06, 0.06)
"""How people differ in these, m."""
VIEW_EXTENT_SIGMA = (0.1, 0.12)
"""Standard deviation of a height and a width by the histograms of one view, m."""
FIRST_SPEED = 1.0
"""Standard deviation of the velocity of a new target, m/s."""
SHARED_M, SHARED_S = 0.25, 1.0
"""Distance to an older target, and time, after which a target shares its image, and ends."""
ENOUGH = 0.5
"""Effective share of the ground particles from which no further round is needed."""
SEEN = -6.0
"""Mean log-likelihood from which a view sees a target; `HIDDEN` is below."""
SHORTEST_S, LONGEST_S = 1e-3, 1.0
"""Between ticks, for the prediction, s."""


@dataclass
class Target:
    """
    A target.

    Attributes
    ----------
    state : (n, 6) array
        Its particles: x, y, height, width, m, and velocity, m/s; equally weighted.
    first_ns, seen_ns, apart_ns : int
        When it began, when a view saw it last, and when no older target was where it is, ns.
    seen_by : tuple of str
        Cameras that saw it in the last tick.

    """

    state: Floats
    first_ns: int
    seen_ns: int
    apart_ns: int
    seen_by: tuple[str, ...] = ()


class GroundBelief:
    """
    Runs Algorithm 1 for all targets, one tick after another.

    Parameters
    ----------
    config : BeliefConfig
        Parameters.

    Attributes
    ----------
    targets : dict of int to Target
        By id, ascending.
    stamp_ns : int
        Of the last tick, ns.
    views : dict of str to Belief
        By camera, the particles of targets of which it said something in the last tick, equally
        weighted.
    last : Round, optional
        Weights and messages of the last round, of all targets and of the cameras of `views`.

    """

    def __init__(self, config: BeliefConfig) -> None:
        self._config = config
        self.targets: dict[int, Target] = {}
        self.stamp_ns = 0
        self.views: dict[str, Belief] = {}
        self.last: Round | None = None

    def start(
        self,
        track_id: int,
        position: Floats,
        covariance: Floats,
        velocity: Floats | None = None,
        extent: Floats | None = None,
    ) -> None:
        """
        Begin a target at the last tick's stamp.

        Parameters
        ----------
        track_id : int
            Its id.
        position, covariance : (2,), (2, 2) arrays
            m, m².
        velocity : (2,) array, optional
            m/s; not known: 0, give or take `FIRST_SPEED`.
        extent : (2,) array, optional
            Height and width, m; not known: the usual ones.

        """
        count = self._config.particles
        rng = stream(self._config.seed, f'start {track_id}', self.stamp_ns)
        mean = np.concatenate(
            [
                position,
                USUAL_EXTENT if extent is None else extent,
                np.zeros(2) if velocity is None else velocity,
            ]
        )
        speed = FIRST_SPEED if velocity is None else FIRST_SPEED / 2
        spread = np.zeros((6, 6))
        spread[:2, :2] = covariance
        spread[range(2, 6), range(2, 6)] = np.square([*EXTENT_SIGMA, speed, speed])
        state = mean + rng.normal(size=(count, 6)) @ np.linalg.cholesky(spread).T
        self.targets[track_id] = Target(state, self.stamp_ns, self.stamp_ns, self.stamp_ns)

    def step(self, views: Mapping[str, Belief], stamp_ns: int) -> list[int]:
        """
        Take what cameras say of one tick; return the ids of targets that end.

        Parameters
        ----------
        views : mapping of str to Belief
            By camera; one that says nothing of a target leaves him to the others.
        stamp_ns : int
            Of the tick, ns; later than the last one.

        Raises
        ------
        ConfigError
            If weights are the printed ones and a camera does not send what they need.

        """
        seconds = float(np.clip((stamp_ns - self.stamp_ns) * 1e-9, SHORTEST_S, LONGEST_S))
        self.stamp_ns, self.views, self.last = stamp_ns, {}, None
        if self.targets:
            self._step(views, seconds)
        keep_ns = round(self._config.keep_time * 1e9)
        return self.end(
            [
                key
                for key, one in self.targets.items()
                if stamp_ns - one.seen_ns > keep_ns or stamp_ns - one.apart_ns > SHARED_S * 1e9
            ]
        )

    def end(self, track_ids: Iterable[int]) -> list[int]:
        """Forget targets; return which there were."""
        over = [key for key in track_ids if key in self.targets]
        for key in over:
            del self.targets[key]
        if over:
            self.views = {
                camera: rows.select(np.isin(rows.track_id, over, invert=True))
                for camera, rows in self.views.items()
            }
        return over

    def belief(self) -> Belief:
        """Return what the cameras are sent: particles in their views, and on the ground."""
        if not self.targets:
            return Belief.build(self.stamp_ns)
        ids = list(self.targets)
        state = np.concatenate([target.state for target in self.targets.values()])
        ground = Belief.build(
            self.stamp_ns,
            position=np.column_stack([state[:, :2], np.zeros(len(state))]),
            extent=state[:, 2:4],
            velocity=state[:, 4:],
            track_id=np.repeat(ids, self._config.particles),
        )
        return Belief.joined(self.stamp_ns, [ground, *self.views.values()])

    def _step(self, views: Mapping[str, Belief], seconds: float) -> None:
        """Predict, exchange messages, resample."""
        ids = list(self.targets)
        rng = stream(self._config.seed, 'ground', self.stamp_ns)
        said = {camera: _said(views[camera], ids) for camera in sorted(views)}
        said = {camera: reported for camera, reported in said.items() if reported}
        samples = [_samples(views[camera], reported, ids) for camera, reported in said.items()]
        state, rounds = self._propagated(samples, seconds, rng)
        self.last = rounds[-1]
        weights = [sum(each) / len(rounds) for each in zip(*[one.views for one in rounds])]
        drawn = systematic_rows(self.last.ground, rng.random(len(ids)))
        seen: dict[int, list[str]] = {track_id: [] for track_id in ids}
        for (camera, reported), weight in zip(said.items(), weights):
            for track_id in self._resample(views[camera], camera, reported, weight, rng):
                seen[track_id].append(camera)
        self._update_targets(np.take_along_axis(state, drawn[..., None], axis=1), seen)

    def _propagated(
        self, samples: list[ViewSamples], seconds: float, rng: np.random.Generator
    ) -> tuple[Floats, list[Round]]:
        """Return the predicted particles of the last round, (t, n, 6), and all rounds."""
        config = self._config
        is_printed = config.weights == 'printed'
        if is_printed and any(np.isnan(each.log_prior).any() for each in samples):
            raise ConfigError('weights printed needs prior_density of all cameras: set it to true')
        before = np.stack([target.state for target in self.targets.values()])
        rounds: list[Round] = []
        while not rounds or (len(rounds) < config.iterations and _are_few(rounds[-1])):
            state = _predicted(before, seconds, rng)
            prior = _log_prior(state, before, seconds) if is_printed else None
            rounds.append(
                propagate(state[..., :4], samples, config.outlier_share, config.weights, prior)
            )
        return state, rounds

    def _resample(
        self,
        view: Belief,
        camera: str,
        reported: Mapping[int, Ints],
        weight: Floats,
        rng: np.random.Generator,
    ) -> list[int]:
        """Resample a view's particles of those of whom it told; return whom it has seen."""
        rows = np.stack(list(reported.values()))
        log = (weight * view.log_likelihood[rows]).sum(axis=1)
        kept = np.take_along_axis(rows, systematic_rows(weight, rng.random(len(rows))), 1)
        self.views[camera] = view.select(kept.ravel())
        seen: list[int] = np.array(list(reported))[log > SEEN].tolist()
        return seen

    def _update_targets(self, state: Floats, seen: Mapping[int, list[str]]) -> None:
        """Give the targets their particles, (t, n, 6), and note who was seen, and who is apart."""
        apart = _are_apart(state[..., :2].mean(axis=1))
        for (track_id, target), particles, is_apart in zip(self.targets.items(), state, apart):
            target.state, target.seen_by = particles, tuple(seen[track_id])
            if seen[track_id]:
                target.seen_ns = self.stamp_ns
            if is_apart:
                target.apart_ns = self.stamp_ns


def _are_few(result: Round) -> bool:
    """Tell whether few of the ground particles of a target have all the weight."""
    count = result.ground.shape[1]
    return bool(effective_size(result.ground).min() < ENOUGH * count)


def _are_apart(place: Floats) -> Mask:
    """Tell which of (t, 2) places, m, are away from all older targets'."""
    x, y = (place[:, None] - place).transpose(2, 0, 1)
    return np.asarray(~np.tril(np.hypot(x, y) < SHARED_M, -1).any(axis=1))


def _predicted(state: Floats, seconds: float, rng: np.random.Generator) -> Floats:
    """Return new samples of the motion model, (t, n, 6)."""
    noise = rng.normal(size=(2, *state.shape[:2], 2))
    place, velocity = moved(state[..., :2], state[..., 4:], seconds, ACCELERATION, noise)
    pull = np.exp(-seconds)
    fresh = rng.normal(size=(*state.shape[:2], 2)) * EXTENT_SIGMA * np.sqrt(1 - pull**2)
    extent = USUAL_EXTENT + pull * (state[..., 2:4] - USUAL_EXTENT) + fresh
    return np.concatenate([place, extent, velocity], axis=-1)


def _log_prior(state: Floats, before: Floats, seconds: float) -> Floats:
    """Return the log-densities, (t, n), by which `_predicted` draws samples, up to a constant."""
    pull = np.exp(-seconds)
    sample = [whitened(state[..., :2], state[..., 4:], seconds), state[..., 2:4]]
    place = before[..., :2] + seconds * before[..., 4:]
    extent = USUAL_EXTENT + pull * (before[..., 2:4] - USUAL_EXTENT)
    mean = np.concatenate([whitened(place, before[..., 4:], seconds), extent], axis=-1)
    variance = [ACCELERATION] * 4 + list(np.square(EXTENT_SIGMA) * (1 - pull**2))
    return log_mixture(
        np.concatenate(sample, axis=-1), mean, np.broadcast_to(variance, mean.shape)
    )


def _said(rows: Belief, ids: list[int]) -> dict[int, Ints]:
    """Return the rows that a camera sent of targets, by id."""
    return {key: own for key, own in rows.by_target(_view_of(rows)).items() if key in ids}


def _view_of(rows: Belief) -> int:
    return int(rows.view[0]) if len(rows) else 0


def _samples(rows: Belief, reported: dict[int, Ints], ids: list[int]) -> ViewSamples:
    """Return what a camera says of targets."""
    index = np.stack(list(reported.values()))
    state = np.concatenate([rows.position[:, :2], rows.extent], axis=1)[index].astype(np.float64)
    possible = np.asarray(np.isfinite(state @ np.ones(4)))
    place = rows.covariance[index].astype(np.float64)
    place[~possible] = np.eye(2)
    likelihood = np.where(possible, rows.log_likelihood[index].astype(np.float64), -np.inf)
    height, width = VIEW_EXTENT_SIGMA
    return ViewSamples.of(
        np.array([ids.index(track_id) for track_id in reported]),
        np.where(possible[..., None], state, 0.0),
        place,
        (height**2, width**2),
        (likelihood, rows.log_prior[index].astype(np.float64)),
        HIDDEN,
    )
