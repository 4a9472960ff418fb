"""The background: what the image looks like without moving objects, by one of several rules."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import OneOf, parameter, tag
from mctrack_ros.perception.background.difference import subtract
from mctrack_ros.perception.background.noise import MEDIAN_OF_LARGEST, NoiseMap
from mctrack_ros.perception.background.rules import (
    ApproximateMedian,
    BackgroundUpdate,
    BufferedMedian,
    Light,
    LowPassRule,
    Mixture,
    Rule,
    median_of_nine,
    relit,
)
from mctrack_ros.perception.background.rules.illumination import (
    explains,
    gains,
    has_changed,
    samples,
)
from mctrack_ros.perception.background.rules.ranks import SAMPLES

Image = NDArray[np.uint8]
NOISE_TIME_S = 0.8
MOST_NOISE = 30.0  # grey levels; nothing can be told from such images
LONGEST_LESSON_S = 1.0  # so long an image counts at most: after a gap it is one like others
LEAP = 2.0  # grey levels by which the median difference grows when the light leaps
LEAST_GAIN = 0.02  # change of light that is followed


@dataclass(frozen=True)
class BackgroundConfig:
    """
    Parameters of `Background`; the rules have subclasses of their own.

    Attributes
    ----------
    model : str
        Which rule it is of.

    """

    model: str
    learning_s: float = parameter(
        0.8, 'time in which the first background is learned; nothing is seen [s]', minimum=0.0
    )
    update_period_s: float = parameter(
        0.2,
        'time between lessons; in each, the approximate median moves by one grey level [s]',
        minimum=0.001,
    )
    threshold_sigmas: float = parameter(
        5.0, 'difference that is foreground, in standard deviations of the noise', minimum=1.0
    )
    minimum_threshold: float = parameter(
        12.0,
        'difference that is foreground at least, in the light of the start [grey levels]',
        minimum=1.0,
        maximum=255.0,
    )
    relearn_fraction: float = parameter(
        0.6, 'changed share of the image from which the background is learned anew',
        minimum=0.05, maximum=1.0,
    )  # fmt: skip


@dataclass(frozen=True)
class MedianConfig(BackgroundConfig):
    """Parameters of a background that is a median."""

    renewal_s: float = parameter(
        20.0,
        'time over which later backgrounds are learned; the first are shorter [s]',
        minimum=0.0,
    )


@dataclass(frozen=True)
class BufferedMedianConfig(MedianConfig):
    """Parameters of a background learned by `BufferedMedian`."""

    model: str = tag('buffered_median')


@dataclass(frozen=True)
class ApproximateMedianConfig(MedianConfig):
    """Parameters of a background learned by `ApproximateMedian`."""

    model: str = tag('approximate_median')


@dataclass(frozen=True)
class LowPassRuleConfig(BackgroundConfig):
    """Parameters of a background learned by `LowPassRule`."""

    model: str = tag('low_pass')
    beta: float = parameter(
        0.1, 'share of a difference learned in 0.25 s', minimum=0.0, maximum=1.0
    )


@dataclass(frozen=True)
class MixtureConfig(BackgroundConfig):
    """Parameters of a background learned by `Mixture`."""

    model: str = tag('mixture')
    memory_s: float = parameter(20.0, 'time constant with which it learns [s]', minimum=0.1)


BACKGROUND: OneOf[BackgroundConfig] = OneOf(
    'model',
    'approximate_median',
    'how the background is learned',
    {
        'approximate_median': ApproximateMedianConfig,
        'buffered_median': BufferedMedianConfig,
        'low_pass': LowPassRuleConfig,
        'mixture': MixtureConfig,
    },
)
"""The choice of how the background is learned."""


LOW_PASS_PERIOD_S = 0.25
RULES: dict[str, Callable[[Any, bool], Rule]] = {
    'approximate_median': lambda config, is_given: ApproximateMedian(
        config.renewal_s if is_given else min(3 * config.learning_s, config.renewal_s),
        config.renewal_s,
    ),
    'buffered_median': lambda config, is_given: BufferedMedian(config.renewal_s),
    'low_pass': lambda config, is_given: LowPassRule(config.beta, LOW_PASS_PERIOD_S),
    'mixture': lambda config, is_given: Mixture(config.memory_s, config.threshold_sigmas),
}


class Background:
    """
    The background model and what differs from it (event-tracking paper, Definitions 1 and 2).

    The first model is given, or the median of nine images; then a rule learns. The threshold
    follows the noise that is measured in the background (sections 3.1 and 4.2; equation (1) with
    the largest of the channels' differences). When light or gain change, the model is made
    brighter or darker at once; what foreground covers follows the light of the rest.

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
        self._take(image.copy(), is_given=True)

    def restart(self) -> None:
        """Forget everything and learn anew."""
        self.model: Image | None = None
        self.difference: Image = np.zeros((0, 0), np.uint8)
        self.noise: float | None = None
        self._samples: list[Image] = []
        self._tracked = np.zeros((0, 4), np.int64)
        self._last_ns = self._lesson_ns = self._next_ns = 0

    @property
    def threshold(self) -> float:
        """Difference from which a pixel is foreground where noise is usual, grey levels."""
        return max(self._thresholds)

    @property
    def _thresholds(self) -> tuple[float, float]:
        """Difference that is no foreground anywhere, and that of usual noise."""
        light = 1.0 if self.model is None else float(self._light.level.mean())
        noise = self._config.threshold_sigmas * (self.noise or 0.0)
        return self._config.minimum_threshold * light, noise

    def apply(self, image: Image, stamp_ns: int) -> Image | None:
        """
        Learn from an image and tell what in it is foreground.

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
        self._rule.attend(self.model, image, stamp_ns)
        measured = self._subtract(image)
        self.noise = measured if self.noise is None else self.noise
        mask, pixels = self._foreground(image)
        has_changed_all = pixels > self._config.relearn_fraction * mask.size
        if has_changed_all or self.noise > MOST_NOISE:
            self.restart()
            return None
        self.noise += (measured - self.noise) * -math.expm1(-seconds / NOISE_TIME_S)
        if stamp_ns >= self._next_ns:
            self._learn(image, mask, stamp_ns)
        return mask

    def track(self, box: NDArray[np.floating]) -> None:
        """Take notice where, in (n, 4) boxes, px, something is tracked: it is not learned."""
        self._tracked = np.rint(box).astype(np.int64)

    def accept(self) -> None:
        """Take notice that the model was changed from outside."""
        assert self.model is not None
        self._rule.accept(self.model)

    def _sample(self, image: Image, stamp_ns: int) -> None:
        """Collect nine images, evenly in time, and take their median."""
        if stamp_ns < self._next_ns:
            return
        self._samples.append(image.copy())
        self._next_ns = stamp_ns + round(self._config.learning_s / SAMPLES * 1e9)
        if len(self._samples) == SAMPLES:
            self._take(median_of_nine(self._samples), is_given=False)
            self._samples = []

    def _take(self, model: Image, is_given: bool) -> None:
        self.model, self._mask = model, np.zeros(model.shape[:2], np.uint8)
        self.difference = np.zeros(model.shape[:2], np.uint8)
        self._light, self._noise_map = Light(model), NoiseMap()
        self._rule = RULES[self._config.model](self._config, is_given)
        self._rule.begin(model)

    def _subtract(self, image: Image) -> float:
        """Write the difference and return the noise that it shows; follow a leap of the light."""
        assert self.model is not None
        measured = subtract(image, self.model, self.difference)
        usual = measured if self.noise is None else MEDIAN_OF_LARGEST * self.noise
        if measured > usual + LEAP and self._follow_light(image):
            measured = subtract(image, self.model, self.difference)
        return measured / MEDIAN_OF_LARGEST

    def _foreground(self, image: Image) -> tuple[Image, int]:
        """Return the foreground and how many pixels of it there are."""
        own = self._rule.foreground(image)
        if own is not None:
            self._mask = own
            return own, cv2.countNonZero(own)
        least, usual = self._thresholds
        return self._mask, self._noise_map.foreground(self.difference, least, usual, self._mask)

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
        self._rule.relight(self.model, change)
        return is_lit

    def _learn(self, image: Image, mask: Image, stamp_ns: int) -> None:
        assert self.model is not None
        since_s = (stamp_ns - self._lesson_ns) * 1e-9 if self._lesson_ns else 0.0
        seconds = min(since_s, LONGEST_LESSON_S)
        self._lesson_ns = stamp_ns
        self._next_ns = stamp_ns + round(self._config.update_period_s * 1e9)
        self._noise_map.learn(self.difference, mask, self.noise or 0.0, seconds)
        self._rule.learn(
            self.model, BackgroundUpdate(image, mask, self._tracked, seconds, stamp_ns)
        )
        self._follow_light(image)
