"""What every rule of learning a background is given, and does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]


@dataclass(frozen=True, eq=False, slots=True)
class BackgroundUpdate:
    """
    One image to learn from.

    Attributes
    ----------
    image : (h, w, 3) uint8 array
        The image.
    mask : (h, w) uint8 array
        Its foreground, 255.
    tracked : (n, 4) int array
        Boxes of what is tracked: left, top, width, height, px.
    seconds : float
        Time since the last lesson, s; 0 at the first.
    stamp_ns : int
        Time of the image, ns.

    """

    image: Image
    mask: Image
    tracked: NDArray[np.int64]
    seconds: float
    stamp_ns: int

    def tracked_mask(self) -> Image:
        """Return where foreground is tracked, 255."""
        kept = np.zeros_like(self.mask)
        low = np.maximum(self.tracked[:, :2], 0)
        high = np.maximum(self.tracked[:, :2] + self.tracked[:, 2:], 0)
        for (left, top), (right, bottom) in zip(low.tolist(), high.tolist()):
            part = (slice(top, bottom), slice(left, right))
            kept[part] = self.mask[part]
        return kept


class Rule(Protocol):
    """How a model of the background (event-tracking paper, Definition 1) learns."""

    def begin(self, model: Image) -> None:
        """Start from a (h, w, 3) uint8 image without moving objects."""

    def foreground(self, image: Image) -> Image | None:
        """Return the (h, w) uint8 foreground by the rule's own test; None: it has none."""

    def learn(self, model: Image, lesson: BackgroundUpdate) -> None:
        """Change the model, in place, by one lesson."""

    def attend(self, model: Image, image: Image, stamp_ns: int) -> None:
        """Look at an image between lessons."""

    def relight(self, model: Image, gain: NDArray[np.float64]) -> None:
        """Take notice that light changed by (3,) factors; the model shows it as of now."""

    def accept(self, model: Image) -> None:
        """Take over what was changed in the model from outside."""
