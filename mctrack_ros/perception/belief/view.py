"""The particle filters of a view: foot, size and velocity of each target in the image."""

from __future__ import annotations

from typing import NamedTuple
from zlib import crc32

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.ground.plausible import PERSON_M
from mctrack_ros.interfaces import Belief
from mctrack_ros.interfaces.belief import HIDDEN
from mctrack_ros.perception.belief.config import BeliefCameraConfig
from mctrack_ros.perception.belief.histograms import squared_distances
from mctrack_ros.perception.belief.observation import box_templates, log_odds
from mctrack_ros.tracking.particles import log_mixture, moved, stream, whitened

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

FOOT_PX, FOOT_SHARE = 0.7, 0.025
"""Standard deviation of a foot, px, and its part that grows with the height in the image."""
ACCELERATION = 2.0
"""Density of the acceleration of people, m²/s³, as on the ground."""
SIZE_RATE = 0.05
"""Standard deviation of the relative change of height and width in a second."""
IN_VIEW = 0.5
"""Share of the particles whose box centre must be in the image for the view to say something."""
LARGEST_OVERLAP = 0.2
"""Colours are learned from a box of which no other target's covers more."""
SHORTEST_S, LONGEST_S = 1e-3, 1.0
"""Between images, for the prediction, s."""


class _Samples(NamedTuple):
    """
    Particles of the k targets in view.

    Attributes
    ----------
    ids : list of int
        Of the targets.
    source, state : (k, n, 6) float64 array
        After the last messages, and at the image.
    place : (k, n, 2) float64 array
        Of the latter on the ground, m; NaN where they are not in the image.

    """

    ids: list[int]
    source: Floats
    state: Floats
    place: Floats


class ViewFilters:
    """
    Predicts and weighs the particles of all targets in one camera.

    Fusion holds what they were after the last messages: between images nothing is kept here but
    the colours of targets.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera; a moving one's is set anew before each step.
    name : str
        Of the camera: keys its random numbers, and its rows.
    config : BeliefCameraConfig, optional
        Parameters; unless given, the usual ones.

    """

    def __init__(
        self, mapping: GroundMapping, name: str, config: BeliefCameraConfig | None = None
    ) -> None:
        self.mapping, self._name = mapping, name
        self._config = config or BeliefCameraConfig()
        self.view = max(crc32(name.encode()), 1)
        self._reference: dict[int, Floats] = {}

    def learn(self, image: Image, track_id: list[int], box: Floats) -> None:
        """Take the colours of targets from (n, 4) boxes, px, of a (h, w, 3) image."""
        found = box_templates(image, box)
        for target, reference in zip(track_id, found):
            if reference.any():
                self._reference[int(target)] = reference

    def step(
        self, image: Image, stamp_ns: int, belief: Belief | None, motion: Floats | None = None
    ) -> Belief:
        """
        Return the particles at an image, with its likelihood; none of targets out of view.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            BGR image.
        stamp_ns : int
            Its time, ns.
        belief : Belief or None
            What fusion sent last.
        motion : (3, 3) array, optional
            Of a moving camera: homography from the image at `belief` to this one.

        """
        if belief is None:
            return Belief.build(stamp_ns)
        ids, source = self._sources(belief, motion)
        self._reference = {key: each for key, each in self._reference.items() if key in ids}
        seconds = float(np.clip((stamp_ns - belief.stamp_ns) * 1e-9, SHORTEST_S, LONGEST_S))
        samples = self._drawn(ids, source, seconds, stamp_ns)
        if not samples.ids:
            return Belief.build(stamp_ns)
        self._learn_new(image, samples.ids, samples.state)
        rows = self._rows(samples)
        log_likelihood = self._log_likelihoods(image, samples.ids, samples.state)
        if self._config.prior_density:
            rows['log_prior'] = _log_prior(samples.state, samples.source, seconds).ravel()
        return Belief.build(stamp_ns, log_likelihood=log_likelihood.ravel(), **rows)

    def image_state(self, belief: Belief) -> Floats:
        """Return the (n, 6) particles in the image of particles on the ground."""
        place, extent = belief.position[:, :2].astype(np.float64), belief.extent
        velocity = np.einsum(
            'nij,nj->ni', self.mapping.image_jacobian(place), belief.velocity.astype(np.float64)
        )
        height = self.mapping.height_px(place, PERSON_M) * extent[:, 0] / PERSON_M
        width = self.mapping.width_px(place, 1.0) * extent[:, 1]
        foot = self.mapping.image_from_ground(place)
        return np.column_stack([foot, height, width, velocity])

    def _sources(self, belief: Belief, motion: Floats | None) -> tuple[list[int], Floats]:
        """
        Return ids, and particles after the last messages, (k, n, 6).

        Those of this view; of a target that is not followed here yet, those on the ground.
        """
        ground = belief.by_target(0)
        count = max(map(len, ground.values()), default=1)
        own = belief.by_target(self.view, count)
        sources = {}
        for key, rows in ground.items():
            if key in own:
                sources[key] = belief.image_state[own[key]]
                continue
            state = self.image_state(belief.select(rows))
            state = state[np.isfinite(state).all(axis=1)]
            if len(state):
                sources[key] = np.resize(state, (count, 6))
        state = np.array(list(sources.values()), np.float64).reshape(-1, count, 6)
        followed = [key in own for key in sources]
        if motion is not None and any(followed):
            state[followed] = _carried(state[followed], np.asarray(motion))
        return list(sources), state

    def _drawn(self, ids: list[int], source: Floats, seconds: float, stamp_ns: int) -> _Samples:
        """Sample the motion model; keep the targets of whom enough is in the image."""
        state = self._predicted(source, seconds, stream(self._config.seed, self._name, stamp_ns))
        place = self.mapping.ground_from_image(state[..., :2].reshape(-1, 2))
        place = place.reshape(*state.shape[:2], 2)
        possible = self._in_image(state) & np.isfinite(place[..., 0])
        place = np.where(possible[..., None], place, np.nan)
        in_view = possible.mean(axis=1) >= IN_VIEW
        kept = [key for key, is_kept in zip(ids, in_view) if is_kept]
        return _Samples(kept, source[in_view], state[in_view], place[in_view])

    @staticmethod
    def _predicted(source: Floats, seconds: float, rng: np.random.Generator) -> Floats:
        """Return (k, n, 6) samples of the motion model."""
        noise = rng.normal(size=(2, *source.shape[:2], 2))
        sizes = rng.normal(size=(*source.shape[:2], 2))
        foot, velocity = moved(source[..., :2], source[..., 4:], seconds, _density(source), noise)
        size = source[..., 2:4] * np.exp(SIZE_RATE * np.sqrt(seconds) * sizes)
        return np.concatenate([foot, size, velocity], axis=-1)

    def _in_image(self, state: Floats) -> Mask:
        """Tell which (k, n, 6) particles have the middle of their box in the image."""
        foot, row, height, width = np.moveaxis(state[..., :4], -1, 0)
        columns, rows = self.mapping.image_size
        middle = row - height / 2
        inside = (foot >= 0) & (foot < columns) & (middle >= 0) & (middle < rows)
        return np.asarray(inside & (height > 1.0) & (width > 1.0))

    def _learn_new(self, image: Image, ids: list[int], state: Floats) -> None:
        """Learn the colours of targets that are seen first, and alone."""
        if self._reference.keys() >= set(ids):
            return
        box = boxes_of(state).mean(axis=1)
        alone = _covered(box).max(axis=1) <= LARGEST_OVERLAP
        new = [row for row, key in enumerate(ids) if alone[row] and key not in self._reference]
        self.learn(image, [ids[row] for row in new], box[new])

    def _log_likelihoods(self, image: Image, ids: list[int], state: Floats) -> Floats:
        """Return the log-likelihoods of particles, (k, n)."""
        weight = self._config.colour_weight
        if not weight:
            return np.zeros(state.shape[:2])
        known = [key in self._reference for key in ids]
        found = np.full(state.shape[:2], HIDDEN)
        if any(known):
            reference = np.stack([self._reference[key] for key in ids if key in self._reference])
            if self._config.likelihood == 'histograms':
                less = squared_distances(image, boxes_of(state[known]), reference)
            else:
                less = 1.0 - log_odds(image, boxes_of(state[known]), reference)
            found[known] = np.logaddexp(-weight * less, HIDDEN)
        return found

    def _rows(self, samples: _Samples) -> dict[str, ArrayLike]:
        """Return columns of a message, a row a particle."""
        track_id = np.repeat(samples.ids, samples.state.shape[1])
        state, place = samples.state.reshape(-1, 6), samples.place.reshape(-1, 2)
        covariance = self.mapping.ground_covariance(place, foot_covariance(state[:, 2]))
        height = state[:, 2] * PERSON_M / self.mapping.height_px(place, PERSON_M)
        return {
            'position': np.column_stack([place, np.zeros(len(place))]),
            'covariance': np.nan_to_num(covariance),
            'extent': np.column_stack([height, state[:, 3] / self.mapping.width_px(place, 1.0)]),
            'image_state': state,
            'track_id': track_id,
            'view': np.full(len(place), self.view),
        }


def _density(source: Floats) -> Floats:
    """Return the density of the acceleration in the image, (k, n, 1) px²/s³."""
    return ACCELERATION * np.square(source[..., 2:3] / PERSON_M)


def _log_prior(state: Floats, source: Floats, seconds: float) -> Floats:
    """Return the log-densities, (k, n), by which `ViewFilters` draws samples, up to a constant."""
    size = np.log(state[..., 2:4])
    sample = [whitened(state[..., :2], state[..., 4:], seconds), size]
    foot = source[..., :2] + seconds * source[..., 4:]
    mean = [whitened(foot, source[..., 4:], seconds), np.log(source[..., 2:4])]
    density = np.repeat(_density(source), 4, axis=-1)
    rate = np.full((*source.shape[:2], 2), SIZE_RATE**2 * seconds)
    log = log_mixture(
        np.concatenate(sample, axis=-1),
        np.concatenate(mean, axis=-1),
        np.concatenate([density, rate], axis=-1),
    )
    return np.asarray(log - size.sum(axis=-1))


def foot_covariance(height: Floats) -> Floats:
    """Return the (n, 2, 2) covariances, px², of feet of people of (n,) heights, px."""
    return np.asarray((FOOT_PX + FOOT_SHARE * height[:, None, None]) ** 2 * np.eye(2))


def boxes_of(state: Floats) -> Floats:
    """Return the (..., 4) boxes, px, of (..., 6) particles."""
    corner = state[..., :2] - state[..., 3:1:-1] * [0.5, 1.0]
    return np.concatenate([corner, state[..., 3:1:-1]], axis=-1)


def _covered(box: Floats) -> Floats:
    """Return the shares of (n, 4) boxes that each other one covers, (n, n); of itself 0."""
    low, high = box[:, :2], box[:, :2] + box[:, 2:]
    shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    share = np.maximum(shared, 0.0).prod(axis=2) / box[:, 2:].prod(axis=1)[:, None]
    return np.asarray(np.where(np.eye(len(box), dtype=bool), 0.0, share))


def _carried(state: Floats, motion: Floats) -> Floats:
    """Return (..., 6) particles in the image that a homography leads to."""
    head = state[..., :2] - state[..., 2:3] * [0.0, 1.0]
    there, top = (
        cv2.perspectiveTransform(each.reshape(-1, 1, 2), motion).reshape(each.shape)
        for each in (np.ascontiguousarray(state[..., :2]), head)
    )
    scale = np.linalg.norm(there - top, axis=-1, keepdims=True) / state[..., 2:3]
    return np.concatenate([there, state[..., 2:] * scale], axis=-1)
