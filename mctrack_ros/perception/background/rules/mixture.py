"""A mixture of Gaussians for each pixel, as OpenCV has it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.background.rules.illumination import relit
from mctrack_ros.perception.background.rules.rule import BackgroundUpdate, Image


class Mixture:
    """
    OpenCV's MOG2 (Zivkovic 2004), without its test for shadows.

    What is tracked is shown to it as the background, so that it does not burn in. It cannot be
    made brighter, so images are shown to it in the light of its start.

    Parameters
    ----------
    memory_s : float
        Time constant with which it learns, s.
    threshold_sigmas : float
        Distance from every Gaussian from which a pixel is foreground, standard deviations.

    """

    def __init__(self, memory_s: float, threshold_sigmas: float) -> None:
        self._memory_s, self._threshold = memory_s, threshold_sigmas**2

    def begin(self, model: Image) -> None:
        """Start from an image; see `Rule`."""
        self._mixture = cv2.createBackgroundSubtractorMOG2(
            varThreshold=self._threshold, detectShadows=False
        )
        self._mixture.apply(model, learningRate=1.0)
        self._light = np.ones(3)

    def foreground(self, image: Image) -> Image | None:
        """Return what no Gaussian of the background explains; see `Rule`."""
        return np.asarray(self._mixture.apply(self._unlit(image), learningRate=0.0), np.uint8)

    def learn(self, model: Image, lesson: BackgroundUpdate) -> None:
        """Learn an image, what is tracked left out; see `Rule`."""
        shown = lesson.image.copy()
        np.copyto(shown, model, where=lesson.tracked_mask()[..., None] > 0)
        share = 1 - np.exp(-lesson.seconds / self._memory_s)
        self._mixture.apply(self._unlit(shown), learningRate=share)
        learned = np.asarray(self._mixture.getBackgroundImage(), np.uint8)
        np.copyto(model, relit(learned, self._light))

    def attend(self, model: Image, image: Image, stamp_ns: int) -> None:
        """Do nothing between lessons."""

    def relight(self, model: Image, gain: NDArray[np.float64]) -> None:
        """Show images in the light of the start, from now on; see `Rule`."""
        self._light = self._light * gain

    def accept(self, model: Image) -> None:
        """Begin anew with a model that was changed from outside."""
        light = self._light
        self.begin(relit(model, 1 / light))
        self._light = light

    def _unlit(self, image: Image) -> Image:
        return relit(image, 1 / self._light)
