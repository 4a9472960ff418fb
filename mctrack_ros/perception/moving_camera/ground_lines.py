"""Painted lines of the ground found in an image, near where they are expected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.moving_camera.turning_camera import TurningCamera

Floats = NDArray[np.float64]
Grey = NDArray[np.uint8]

_SPACING_M = 0.5  # between samples along a line
_APART_PX = 4.0  # between those that are used, so that near lines do not count most
_CONTRAST = 25.0  # of paint to the ground on both sides, grey levels
_WIDEST_PX = 6  # half the width of the widest line


@dataclass(frozen=True, eq=False, slots=True)
class GroundLines:
    """
    Painted lines, sampled.

    Attributes
    ----------
    place : (n, 3) array
        Samples, m, on the ground.
    along : (n, 3) array
        Unit vectors along the line there.

    """

    place: Floats
    along: Floats

    @classmethod
    def of(cls, polylines: Sequence[Floats]) -> GroundLines:
        """Sample polylines, each (k, 2) m."""
        places, alongs = [np.empty((0, 2))], [np.empty((0, 2))]
        for line in polylines:
            for start, end in pairwise(line):
                length = float(np.linalg.norm(end - start))
                count = max(round(length / _SPACING_M), 1)
                share = (np.arange(count)[:, None] + 0.5) / count
                places.append(start + share * (end - start))
                alongs.append(np.tile((end - start) / max(length, 1e-9), (count, 1)))
        place, along = np.concatenate(places), np.concatenate(alongs)
        ground = np.zeros((len(place), 1))
        return cls(np.hstack([place, ground]), np.hstack([along, ground]))

    def found_in(
        self, grey: Grey, still: NDArray[np.uint8], guess: TurningCamera, reach_px: float
    ) -> tuple[Floats, Floats, Floats]:
        """
        Look for bright ridges across the expected lines.

        Parameters
        ----------
        grey : (height, width) array
            The image.
        still : (height, width) array
            0 where people are.
        guess : TurningCamera
            About how the camera looks.
        reach_px : float
            How far from the expected place to look, px.

        Returns
        -------
        rays : (n, 3) array
            Directions in the world of the samples found.
        pixel : (n, 2) array
            Where the lines cross the normals through the expected places, px.
        normal : (n, 2) array
            These normals.

        """
        margin = reach_px + _WIDEST_PX
        rays, expected, normal = self._expected(guess, grey.shape, margin)
        if not len(rays):
            return rays, expected, normal
        offsets = np.arange(-margin, margin + 0.25, 0.5)
        places = expected[:, None] + offsets[:, None] * normal[:, None] - 0.5
        column, row = np.moveaxis(places.astype(np.float32), -1, 0)
        across = cv2.remap(grey, column, row, cv2.INTER_LINEAR).astype(np.float64)
        free = cv2.remap(still, column, row, cv2.INTER_NEAREST).min(axis=1) > 0
        shift, height = _highest(_ridges(across), offsets, reach_px)
        good = free & (height > _CONTRAST)
        pixel = expected + shift[:, None] * normal
        return rays[good], pixel[good], normal[good]

    def _expected(
        self, guess: TurningCamera, shape: tuple[int, ...], margin: float
    ) -> tuple[Floats, Floats, Floats]:
        """Return rays, pixels and normals of samples well inside the image, spread over it."""
        rays = self.place - guess.position
        expected, further = guess.project(rays), guess.project(rays + 0.1 * self.along)
        step = further - expected
        length = np.linalg.norm(step, axis=1, keepdims=True)
        normal = np.column_stack([-step[:, 1], step[:, 0]]) / np.maximum(length, 1e-9)
        inside = np.isfinite(step).all(axis=1)
        inside &= (expected > margin).all(axis=1)
        inside &= (expected < np.array(shape[::-1]) - margin).all(axis=1)
        kept = np.flatnonzero(inside)[_spread(expected[inside])]
        return rays[kept], expected[kept], normal[kept]


def _highest(ridge: Floats, offsets: Floats, reach_px: float) -> tuple[Floats, Floats]:
    """Return where the highest ridge of each (n, k) profile is, (n,) px, and its height."""
    within = np.abs(offsets) <= reach_px
    best = np.where(within, ridge, -1).argmax(axis=1)
    around = np.clip(best[:, None] + np.arange(-4, 5), 0, len(offsets) - 1)
    weight = np.maximum(np.take_along_axis(ridge, around, axis=1) - _CONTRAST / 2, 0)
    total = np.maximum(weight.sum(axis=1), 1e-9)
    shift = (weight * offsets[around]).sum(axis=1) / total
    return shift, ridge[np.arange(len(best)), best]


def _ridges(across: Floats) -> Floats:
    """Return by how much each place of the (n, k) profiles is above both sides (top hat)."""
    element = np.ones((1, 4 * _WIDEST_PX + 1), np.uint8)
    return np.asarray(cv2.morphologyEx(across, cv2.MORPH_TOPHAT, element), np.float64)


def _spread(pixel: Floats) -> NDArray[np.int64]:
    """Return the indices of one of the (n, 2) pixels in each small square of the image."""
    squares = np.floor(pixel / _APART_PX).astype(np.int64)
    return np.sort(np.unique(squares, axis=0, return_index=True)[1])
