"""The paper's baselines: Condensation in each view, and what is made of two of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Belief
from mctrack_ros.perception.belief.config import BeliefCameraConfig
from mctrack_ros.perception.belief.view import ViewFilters
from mctrack_ros.tracking.particles import normalised, stream, systematic_rows

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]


class Estimate(NamedTuple):
    """
    Where the t targets are, as one view has it.

    Attributes
    ----------
    mean : (t, 2) array
        On the ground, m; NaN: the view does not show the target.
    covariance : (t, 2, 2) array
        m².
    log_likelihood : (t,) array
        Of the image, in the mean over the particles.

    """

    mean: Floats
    covariance: Floats
    log_likelihood: Floats


class Condensation:
    """
    The particle filter of one view alone (Isard and Blake 1998).

    Particles, motion and likelihood are those of the view in belief propagation.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.
    name : str
        Of the camera.
    config : BeliefCameraConfig
        Parameters of the view.
    start : Belief
        Particles of the targets on the ground.

    Attributes
    ----------
    belief : Belief
        The particles after the last image, as fusion would send them.

    """

    def __init__(
        self, mapping: GroundMapping, name: str, config: BeliefCameraConfig, start: Belief
    ) -> None:
        self._filters = ViewFilters(mapping, name, config)
        self._name, self._seed = name, config.seed
        self._ids = list(start.by_target(0))
        self.belief = start

    def step(
        self, image: Image, stamp_ns: int, mapping: GroundMapping, motion: Floats | None = None
    ) -> Estimate:
        """
        Process one image.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            BGR image.
        stamp_ns : int
            Its time, ns.
        mapping : GroundMapping
            Of the camera at this image.
        motion : (3, 3) array, optional
            Of a moving camera: homography from the image before to this one.

        """
        self._filters.mapping = mapping
        rows = self._filters.step(image, stamp_ns, self.belief, motion)
        own = rows.by_target(self._filters.view)
        rng = stream(self._seed, f'condensation {self._name}', stamp_ns)
        count = len(self._ids)
        mean, covariance = np.full((count, 2), np.nan), np.tile(np.eye(2), (count, 1, 1))
        log_likelihood, kept = np.full(count, -np.inf), []
        for row, key in enumerate(self._ids):
            if key not in own:
                continue
            index = own[key]
            place = rows.position[index, :2].astype(np.float64)
            log = np.where(np.isfinite(place[:, 0]), rows.log_likelihood[index], -np.inf)
            weight = normalised(log)
            known = np.nan_to_num(place)
            mean[row] = weight @ known
            offset = (known - mean[row]) * np.sqrt(weight)[:, None]
            covariance[row] = offset.T @ offset + (
                weight[:, None, None] * rows.covariance[index]
            ).sum(0)
            log_likelihood[row] = np.log(np.exp(log).mean())
            kept.append(index[systematic_rows(weight, rng.random())])
        self._keep(rows, kept)
        return Estimate(mean, covariance, log_likelihood)

    def learn(self, image: Image, track_id: list[int], box: Floats) -> None:
        """Take the colours of targets from (n, 4) boxes, px, of a (h, w, 3) image."""
        self._filters.learn(image, track_id, box)

    def give(self, start: Belief) -> None:
        """Start targets anew by particles on the ground."""
        stamp_ns = self.belief.stamp_ns
        others = self.belief.select(~np.isin(self.belief.track_id, start.track_id))
        self.belief = Belief.joined(stamp_ns, [others, start.at(stamp_ns)])

    def _keep(self, rows: Belief, kept: list[NDArray[np.int64]]) -> None:
        """Go on from some rows; a target that the view does not show stays where it was."""
        if not kept:
            self.belief = self.belief.at(rows.stamp_ns)
            return
        own = rows.select(np.concatenate(kept))
        old = self.belief.select(
            (self.belief.view == 0) & ~np.isin(self.belief.track_id, own.track_id)
        )
        ground = own.replace(view=np.zeros(len(own), np.uint32))
        self.belief = Belief.joined(rows.stamp_ns, [old.at(rows.stamp_ns), ground, own])


def central(estimates: list[Estimate]) -> Floats:
    """Return the mean of all views, (t, 2) m, weighed by their covariances: centralised fusion."""
    places = []
    for means, covariances in zip(
        np.stack([each.mean for each in estimates], axis=1),
        np.stack([each.covariance for each in estimates], axis=1),
    ):
        seen = np.isfinite(means[:, 0])
        information = np.linalg.inv(covariances[seen]).sum(axis=0)
        pull = np.einsum('vij,vj->i', np.linalg.inv(covariances[seen]), means[seen])
        places.append(np.linalg.solve(information, pull) if seen.any() else np.full(2, np.nan))
    return np.array(places)


def best_view(estimates: list[Estimate]) -> Floats:
    """Return where the view has each target, (t, 2) m, whose image is likeliest (Nummiaro)."""
    best = np.argmax([each.log_likelihood for each in estimates], axis=0)
    means = np.stack([each.mean for each in estimates])
    return np.asarray(means[best, np.arange(means.shape[1])])
