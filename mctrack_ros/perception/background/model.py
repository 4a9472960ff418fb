"""The background: what the image looks like without moving objects."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, compiled
from mctrack_ros.config import parameter
from mctrack_ros.perception.background.difference import subtract
from mctrack_ros.perception.background.light import (
    Gains,
    Light,
    explains,
    gains,
    has_changed,
    relit,
    samples,
)
from mctrack_ros.perception.background.noise import MEDIAN_OF_LARGEST, NoiseMap
from mctrack_ros.perception.background.plate import SAMPLES, median_of_nine
from mctrack_ros.perception.background.stillness import Stillness
from mctrack_ros.perception.background.view_change import scene_after

Image = NDArray[np.uint8]
WRITABLE = types.Array(types.u1, 3, 'C')
PERIOD_S = 0.2
"""Time between lessons; in each, the background moves by one grey level."""
NOISE_TIME_S = 0.8
MOST_NOISE = 30.0  # grey levels; nothing can be told from such images
LONGEST_STEP_S = 1.0  # so long an image counts at most: after a gap it is one like others
LEAP = 2.0  # grey levels by which the median difference grows when the light leaps
LEAST_GAIN = 0.02  # change of light that is followed
JUMP_SHARE = 0.05
"""Share of the image that changes from one to the next when the light or the view does."""
RELEARN_SHARE = 0.6  # changed share of the image from which the background is learned anew


@dataclass(frozen=True)
class BackgroundConfig:
    """Parameters of `Background`."""

    learning_s: float = parameter(
        0.8, 'time in which the first background is learned; nothing is seen [s]', minimum=0.0
    )
    threshold_sigmas: float = parameter(
        5.0,
        'difference that is foreground, in standard deviations of the noise',
        minimum=0.0,
        at_run_time=True,
    )
    minimum_threshold: float = parameter(
        12.0,
        'difference that is foreground at least, in the light of the start [grey levels]',
        minimum=1.0,
        maximum=255.0,
        at_run_time=True,
    )
    still_s: float = parameter(
        6.0,
        'time after which an object that lies still becomes background, unless it walked in; 0: '
        'never, and no place is sought that somebody left [s]',
        minimum=0.0,
        maximum=25.0,
    )


class Background:
    """
    The background model and what differs from it (event-tracking paper, Definitions 1 and 2).

    The first model is given, or the median of nine images; then it is an approximate median
    (section 3.1) of what is no object, so changes of light are learned and people are not. The
    threshold follows the noise that is measured in the background (section 4.2; equation (1)
    with the largest of the channels' differences). When light or gain change, the model is made
    brighter or darker at once; what foreground covers follows the light of the rest. Objects
    that lie still become background; see `Stillness`.

    Parameters
    ----------
    config : BackgroundConfig
        Parameters.

    Attributes
    ----------
    model : (h, w, 3) uint8 array or None
        The background.
    difference : (h, w) uint8 array
        Largest of the channels' differences of the last image from the model.
    noise : float or None
        Standard deviation of a channel's noise, grey levels.

    """

    def __init__(self, config: BackgroundConfig) -> None:
        self._config = config
        self.restart()

    def begin(self, image: Image) -> None:
        """Take a (height, width, 3) uint8 image without moving objects for the background."""
        self._take(image.copy())

    def restart(self) -> None:
        """Forget everything and learn anew."""
        self.model: Image | None = None
        self.difference: Image = np.zeros((0, 0), np.uint8)
        self.noise: float | None = None
        self._samples: list[Image] = []
        self._people: Image = np.zeros((0, 0), np.uint8)
        self._changed = 0
        self._noise_map, self._stillness = NoiseMap(), Stillness(self._config.still_s)
        self._last_ns = self._learned_ns = self._next_ns = 0

    @property
    def threshold(self) -> float:
        """Difference from which a pixel is foreground where noise is usual, grey levels."""
        return max(self._thresholds)

    @property
    def light(self) -> Gains:
        """How much brighter, (3,), the channels are than at the start."""
        return np.ones(3) if self.model is None else self._light.level

    @property
    def _thresholds(self) -> tuple[float, float]:
        """Difference that is no foreground anywhere, and that of usual noise."""
        light = float(self.light.mean())
        noise = self._config.threshold_sigmas * (self.noise or 0.0)
        return self._config.minimum_threshold * light, noise

    def apply(self, image: Image, stamp_ns: int) -> Image | None:
        """
        Tell what in an image differs from the background.

        Parameters
        ----------
        image : (height, width, 3) uint8 array
            The image.
        stamp_ns : int
            Its time, ns; later than the last.

        Returns
        -------
        (height, width) uint8 array or None
            255 where the image differs from the background, until the next call; None while it
            is learned.

        """
        seconds, self._last_ns = (stamp_ns - self._last_ns) * 1e-9, stamp_ns
        if self.model is None:
            self._sample(image, stamp_ns)
            return None
        measured = self._subtract(image)
        self.noise = measured if self.noise is None else self.noise
        pixels = self._noise_map.foreground(self.difference, *self._thresholds, self._mask)
        if pixels - self._changed > JUMP_SHARE * self._mask.size:
            pixels = self._look_anew(image, pixels)
        self._changed = pixels
        if pixels > RELEARN_SHARE * self._mask.size or self.noise > MOST_NOISE:
            self.restart()
            return None
        self.noise += (measured - self.noise) * -math.expm1(-seconds / NOISE_TIME_S)
        return self._mask

    def learn(
        self, image: Image, objects: Image, people: Image, walked: Image, stamp_ns: int
    ) -> None:
        """
        Learn from the image that was last looked at, if it is time for a lesson.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            The image.
        objects : (h, w) uint8 array
            Its foreground that no change of light explains, 255.
        people, walked : (h, w) uint8 arrays
            Not 0 in boxes of what is tracked, and of what came by itself.
        stamp_ns : int
            Time of the image, ns.

        """
        self._people = people
        if self.model is None or stamp_ns < self._next_ns:
            return
        since_s = (stamp_ns - self._learned_ns) * 1e-9 if self._learned_ns else 0.0
        seconds = min(since_s, LONGEST_STEP_S)
        self._learned_ns = stamp_ns
        self._next_ns = stamp_ns + round(PERIOD_S * 1e9)
        self._noise_map.learn(self.difference, self._mask, self.noise or 0.0, seconds)
        kept = cv2.bitwise_or(objects, cv2.bitwise_and(self._mask, people))
        approach(self.model, image, np.asarray(kept, np.uint8))
        if self._config.still_s > 0.0:
            self._stillness.note(image, objects, round(self.threshold), seconds)
            self._stillness.settle(image, self.model, objects, walked)
        self._follow_light(image)

    def _sample(self, image: Image, stamp_ns: int) -> None:
        """Collect nine images, evenly in time, and take their median."""
        if stamp_ns < self._next_ns:
            return
        self._samples.append(image.copy())
        self._next_ns = stamp_ns + round(self._config.learning_s / SAMPLES * 1e9)
        if len(self._samples) == SAMPLES:
            self._take(median_of_nine(self._samples))
            self._samples = []

    def _take(self, model: Image) -> None:
        self.model, self._mask = model, np.zeros(model.shape[:2], np.uint8)
        self.difference = np.zeros(model.shape[:2], np.uint8)
        self._people = np.zeros_like(self._mask)
        self._changed = 0
        self._light = Light(model)
        self._noise_map, self._stillness = NoiseMap(), Stillness(self._config.still_s)

    def _subtract(self, image: Image) -> float:
        """Write the difference and return the noise that it shows; follow a leap of the light."""
        assert self.model is not None
        measured = subtract(image, self.model, self.difference)
        usual = measured if self.noise is None else MEDIAN_OF_LARGEST * self.noise
        if measured > usual + LEAP and self._follow_light(image):
            measured = subtract(image, self.model, self.difference)
        return measured / MEDIAN_OF_LARGEST

    def _look_anew(self, image: Image, pixels: int) -> int:
        """Take over the light, or the view, of an image if that is what has changed."""
        assert self.model is not None
        after = scene_after(image, self.model, self._mask, self._people)
        if after is None:
            return pixels
        np.copyto(self.model, after)
        self._light = Light(self.model)
        subtract(image, self.model, self.difference)
        return self._noise_map.foreground(self.difference, *self._thresholds, self._mask)

    def _follow_light(self, image: Image) -> bool:
        """
        Make the model as bright as an image, if that explains how they differ.

        What foreground covers follows the light since it was last followed; the rest may have
        learned some of it.
        """
        assert self.model is not None
        change = self._light.follow(image, LEAST_GAIN)
        gain = gains(samples(image), samples(self.model))
        is_lit = has_changed(gain, LEAST_GAIN) and explains(gain, image, self.model)
        if not is_lit and (change == 1.0).all():
            return False
        lit = self.model
        if is_lit:
            lit = relit(self.model, gain)
            np.copyto(lit, image, where=self.model == 255)
        cv2.copyTo(relit(self.model, change), self._mask, lit)
        np.copyto(self.model, lit)
        return is_lit


@compiled(types.void(WRITABLE, BYTES_3D, BYTES_2D))
def approach(model: Image, image: Image, kept: Image) -> None:
    """
    Move every pixel of a model by one grey level towards an image.

    Parameters
    ----------
    model, image : (h, w, 3) uint8 array
        The model, changed in place, and the image.
    kept : (h, w) uint8 array
        Not 0 where the model stays as it is.

    """
    old, new, stays = model.reshape(-1), image.reshape(-1), kept.reshape(-1)
    for index in range(len(stays)):  # flat: so the compiler makes vectors of it
        moves = np.uint8(stays[index] == 0)
        for channel in range(3):
            place = 3 * index + channel
            up, down = np.uint8(new[place] > old[place]), np.uint8(new[place] < old[place])
            old[place] = np.uint8(old[place] + np.uint8(up & moves) - np.uint8(down & moves))
