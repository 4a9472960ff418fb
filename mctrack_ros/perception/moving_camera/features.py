"""Features of a key image found again in later ones."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.moving_camera.turning_camera import TurningCamera

Floats = NDArray[np.float64]
Grey = NDArray[np.uint8]

MOST = 300  # corners of a key image
LEAST = 4  # features that fix a homography
_QUALITY, _APART_PX = 0.01, 12  # of corners: share of the strongest one's strength, and distance
_RANSAC_PX = 1.5  # a feature farther from the homography is on something that moves
_BACK_PX = 0.7  # a feature tracked back must end as near to where it began
_WINDOW, _LEVELS = (15, 15), 3  # of the pyramid of Lucas and Kanade
_HALF = 0.5  # OpenCV's pixel centres lie at whole numbers, the project's at halves


@dataclass(frozen=True, eq=False, slots=True)
class KeyImage:
    """
    An image with features, and the camera that took it.

    Attributes
    ----------
    grey : (height, width) array
        The image.
    camera : TurningCamera
        As it was estimated.
    pixel : (n, 2) array
        Features, px.

    """

    grey: Grey
    camera: TurningCamera
    pixel: Floats

    @classmethod
    def of(cls, grey: Grey, still: NDArray[np.uint8], camera: TurningCamera) -> KeyImage:
        """Return the key image; features lie where the (height, width) mask of still is not 0."""
        found = cv2.goodFeaturesToTrack(grey, MOST, _QUALITY, _APART_PX, mask=still)
        pixel = np.empty((0, 2)) if found is None else found.reshape(-1, 2).astype(np.float64)
        return cls(grey, camera, pixel + _HALF)

    def found_in(
        self, grey: Grey, still: NDArray[np.uint8], guess: TurningCamera
    ) -> tuple[Floats, Floats]:
        """
        Find the features in another image: pyramidal Lucas-Kanade to and fro, then RANSAC.

        Parameters
        ----------
        grey : (height, width) array
            The other image.
        still : (height, width) array
            0 where people are.
        guess : TurningCamera
            About how the camera looks.

        Returns
        -------
        rays : (n, 3) array
            Directions in the world of those found, by the key image's camera.
        pixel : (n, 2) array
            Where they are, px.

        """
        rays = self.camera.rays(self.pixel)
        expected = guess.project(rays)
        inside = np.isfinite(expected).all(axis=1)
        inside &= ((expected >= 0) & (expected < grey.shape[::-1])).all(axis=1)
        rays, before, start = rays[inside], self.pixel[inside], expected[inside]
        if len(rays) < LEAST:
            return rays[:0], start[:0]
        one, other = ((each - _HALF).astype(np.float32) for each in (before, start))
        found, good = _to_and_fro(self.grey, grey, one, other)
        column, row = np.clip(found.astype(int), 0, np.array(grey.shape[::-1]) - 1).T
        kept = _agreeing(one, found, np.flatnonzero(good & (still[row, column] > 0)))
        return rays[kept], found[kept].astype(np.float64) + _HALF


def _agreeing(
    one: NDArray[np.float32], found: NDArray[np.float32], rows: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Return those of some rows, (n,), of (m, 2) pixels that one homography leads to others."""
    if len(rows) < LEAST:
        return rows[:0]
    homography, agrees = cv2.findHomography(one[rows], found[rows], cv2.RANSAC, _RANSAC_PX)
    return rows[:0] if homography is None else rows[agrees.ravel() > 0]


def _to_and_fro(
    before: Grey, after: Grey, pixel: NDArray[np.float32], guess: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return where (n, 2) pixels went, near a guess, and which came back when followed back."""
    found, good = _flow(before, after, pixel, guess)
    back, is_back = _flow(after, before, found, pixel)
    return found, good & is_back & (np.linalg.norm(back - pixel, axis=1) < _BACK_PX)


def _flow(
    before: Grey, after: Grey, pixel: NDArray[np.float32], guess: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return where (n, 2) pixels went, near a guess, and which were found."""
    found, ok, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        pixel,
        guess.copy(),
        winSize=_WINDOW,
        maxLevel=_LEVELS,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    return np.asarray(found, np.float32), np.asarray(ok).ravel() > 0
