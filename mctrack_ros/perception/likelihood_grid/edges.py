"""Edges of an image that the empty scene does not have (likelihood-grid paper, section 4.2)."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
Floats = NDArray[np.float32]

ORIENTATIONS = 12
"""Directions from 0 to pi (section 6)."""
LEARNING_IMAGES = 30
"""Images without people that the background is learned from (section 6)."""
SAME_DIRECTION = 0.9
"""Cosine from which an edge runs like that of the background (theta of equation 2, section 6)."""
NEAR_PX = 2.5
"""Thresholded distance to an edge of the background ("a few pixels")."""
WEAK_EDGE, STRONG_EDGE = 20.0, 60.0
"""Hysteresis of Canny's edges, gradient of Sobel's 3 x 3 operator."""
FAINT = 0.5
"""The background's edges are sought at so much lower thresholds: those that light makes stronger,
or noise now and then, are known already."""
_BLUR_PX = 1.0  # standard deviation of the smoothing before gradients


class Gradient(NamedTuple):
    """
    Sobel's derivatives of a grey image, smoothed.

    Attributes
    ----------
    across, down : (h, w) int16 array
        By columns and rows, eight times the grey levels a pixel.

    """

    across: NDArray[np.int16]
    down: NDArray[np.int16]

    def edges(self, share: float = 1.0) -> Image:
        """Return Canny's edges, (h, w) with 255, at a share of the thresholds."""
        weak, strong = share * WEAK_EDGE, share * STRONG_EDGE
        return cv2.Canny(self.across, self.down, weak, strong, L2gradient=True)  # type: ignore[return-value]


class Edges(NamedTuple):
    """
    Edge points of an image.

    Attributes
    ----------
    pixel : (n,) int array
        Indices into the flat image, ascending.
    direction : (n,) uint8 array
        That of the gradient, of `ORIENTATIONS` from 0 to pi; it has no sign.

    """

    pixel: NDArray[np.int64]
    direction: Image

    def within(self, mask: Image) -> Edges:
        """Return those where a mask, (h, w), is not 0."""
        kept = mask.ravel()[self.pixel] > 0
        return Edges(self.pixel[kept], self.direction[kept])


def gradient_of(image: Image) -> Gradient:
    """Return the gradient of a BGR image, (h, w, 3)."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    grey = cv2.GaussianBlur(grey, (5, 5), _BLUR_PX)
    across, down = cv2.spatialGradient(grey)
    return Gradient(np.asarray(across), np.asarray(down))


class EdgeBackground:
    """Edges of the empty scene: Canny's by OR, Sobel's directions by their mean."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Learn anew."""
        self._count = 0
        self._near: NDArray[np.bool_] | None = None
        self._edges: Image | None = None
        self._sum: tuple[Floats, Floats] | None = None
        self._unit: tuple[Floats, Floats] | None = None

    @property
    def is_learned(self) -> bool:
        """Whether it has seen enough images."""
        return self._near is not None

    def learn(self, gradient: Gradient, images: int = LEARNING_IMAGES) -> None:
        """Take an image of the empty scene, the last one of so many."""
        edges = gradient.edges(FAINT)
        across, down = (part.astype(np.float32) for part in gradient)
        if self._edges is None or self._sum is None:
            self._edges, self._sum = edges, (across, down)
        else:
            cv2.bitwise_or(self._edges, edges, self._edges)
            self._sum = self._sum[0] + across, self._sum[1] + down
        self._count += 1
        if self._count >= images:
            self._conclude()

    def foreground(self, gradient: Gradient) -> Edges:
        """Return the edges of an image that are not the background's (equation 2)."""
        index = np.flatnonzero(gradient.edges() > 0)
        across = gradient.across.ravel()[index].astype(np.float32)
        down = gradient.down.ravel()[index].astype(np.float32)
        if self._near is not None and self._unit is not None:
            along = self._unit[0].ravel()[index] * across + self._unit[1].ravel()[index] * down
            known = self._near.ravel()[index] & (along > SAME_DIRECTION * np.hypot(across, down))
            index, across, down = index[~known], across[~known], down[~known]
        turn = np.arctan2(down, across) * (ORIENTATIONS / np.pi)
        direction = np.mod(np.rint(turn), ORIENTATIONS).astype(np.uint8)
        return Edges(index, direction)

    def _conclude(self) -> None:
        """Normalise the gradient (equation 1), threshold the distance to the edges."""
        assert self._edges is not None
        assert self._sum is not None
        distance = cv2.distanceTransform(cv2.bitwise_not(self._edges), cv2.DIST_L2, 5)
        self._near = np.asarray(distance <= NEAR_PX)
        length = np.maximum(np.hypot(*self._sum), np.float32(1e-6))
        self._unit = np.divide(self._sum[0], length), np.divide(self._sum[1], length)
