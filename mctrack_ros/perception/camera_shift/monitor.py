"""Notices that a camera has moved since it was calibrated, from what stands still before it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import StrEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.perception.camera_shift.patches import (
    Grey,
    Motion,
    Patches,
    median_motion,
    prepared,
)
from mctrack_ros.perception.camera_shift.phase_correlation import coarse_shifts, reduced


class RankedImages:
    """
    Images sorted at each pixel, and how they lay.

    Passers-by are darker or brighter than what is behind them, so where they cover a pixel less
    than half of the time its median shows what stands still. One image is sorted in at a time
    (an insertion, each exchange a minimum and a maximum of whole images), so no image waits
    for all.

    """

    def __init__(self) -> None:
        self._ranked: list[Grey] = []
        self._motions: list[Motion] = []

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._ranked)

    def add(self, grey: Grey, motion: Motion) -> None:
        """Sort an image in that lies so over the reference."""
        rest = grey
        for rank, ranked in enumerate(self._ranked):
            self._ranked[rank] = cv2.min(ranked, rest)  # type: ignore[assignment]
            rest = cv2.max(ranked, rest)  # type: ignore[assignment]
        self._ranked.append(rest)
        self._motions.append(motion)

    def median(self) -> tuple[Grey, Motion]:
        """Return the median image and how it lies; there must be an image."""
        return self._ranked[len(self._ranked) // 2], median_motion(self._motions)

    def clear(self) -> None:
        """Forget the images."""
        self._ranked.clear()
        self._motions.clear()


PERIOD_S = 0.4
"""Time between looks: ten in the time over which a shift must last."""
RENEWAL_S = 20.0
"""Time after which patches that are seldom found are exchanged: light changes slower."""
UNKNOWN_PX = 20.0
"""Noise added to places in the image while the first view is not found again: a large shift."""
SEARCH_PX = 5  # around the last and the lasting shift
WIDE_SEARCH_PX = 12  # around a coarse shift, which is told in pixels of a reduced image
CLOSE_PX = 2.5  # shifts that differ by less count as one
ROUNDS = 3  # of searches, each around what the one before found
COARSE_NS = 1_000_000_000  # between phase correlations; twice as long once they find nothing
LONGEST_COARSE_NS = 2_000_000_000  # less than the time in which a shift must be found
KEPT = 9  # images in a reference
LEARNING_SHARE = 0.6  # of the settling time; in the rest the reference is tried
LEAST_MEASURES = 3  # looks of which a shift is told
LEAST_SPAN = 0.75  # of the time over which a shift must last
END_SHARE = 0.5  # of the threshold, below which an alarm ends


@dataclass(frozen=True)
class CameraShiftConfig:
    """Parameters of `CameraShiftMonitor`."""

    threshold_px: float = parameter(
        1.4, 'lasting shift from which the camera counts as moved [px]', minimum=0.2
    )
    sustain_s: float = parameter(
        4.0, 'time of whose shifts the median counts; found in about half of it [s]', minimum=0.1
    )
    settling_s: float = parameter(
        10.0,
        'time after the start whose median image and shift are taken for no shift [s]',
        minimum=0.0,
    )


class ShiftState(StrEnum):
    """What is known about the camera's pose."""

    SETTLING = 'settling'
    STILL = 'still'
    MOVED = 'moved'
    UNKNOWN = 'unknown'


@dataclass(frozen=True, slots=True)
class CameraShift:
    """
    How far the image lies from where it was at the start.

    Attributes
    ----------
    state : ShiftState
        Whether that is much.
    size_px : float
        Root mean square over the image, px.
    right_px, down_px : float
        Of the image's middle, px.
    turn_deg : float
        Clockwise as seen.
    patches : int
        How many agreed when last looked.
    noise_px : float
        Standard deviation that it adds to a place in the image along each axis, px.

    """

    state: ShiftState = ShiftState.SETTLING
    size_px: float = 0.0
    right_px: float = 0.0
    down_px: float = 0.0
    turn_deg: float = 0.0
    patches: int = 0
    noise_px: float = 0.0


class CameraShiftMonitor:
    """
    Compares patches of what stood still at first with later images (beyond the papers).

    The background model follows a moved image, so it is not asked: a patch whose texture is
    found again votes for where the image lies, one behind people is not found. Most of those
    found must agree on one shift, turn and zoom. The median of some seconds counts, so wind does
    not. The patches are those of the median of several images, so it may be crowded at first;
    if they are not found again (the camera shook, or showed nothing) all begins anew. Patches
    that are seldom found are exchanged under the motion that the others show: the first seconds
    stay the reference through a changing day.

    Parameters
    ----------
    config : CameraShiftConfig
        Parameters.
    allowed : (h, w) uint8 array, optional
        0 where the image is to be ignored.

    Attributes
    ----------
    shift : CameraShift
        What is known now.

    """

    def __init__(self, config: CameraShiftConfig, allowed: Grey | None = None) -> None:
        self._config, self._allowed = config, allowed
        self._patches: Patches | None = None
        self._recent: deque[tuple[int, Motion]] = deque()
        self._settled = False
        self._last = self._held = Motion()
        self._learning_ns = _ns(LEARNING_SHARE * config.settling_s)
        self._kept = RankedImages()
        self._next_ns = self._renewal_ns = self._coarse_ns = self._keep_ns = 0
        self._coarse_wait_ns = COARSE_NS
        self._looked_ns: int | None = None
        self.shift = CameraShift()

    def watch(self, image: NDArray[np.uint8], stamp_ns: int) -> CameraShift:
        """
        Look at an image, if it is time to.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            Blue, green, red; always of one size.
        stamp_ns : int
            Its time, ns. A step back forgets what was measured last, but not the reference.

        """
        if self._looked_ns is not None and stamp_ns < self._looked_ns:
            self._recent.clear()
            self._forget_kept(stamp_ns)
            self._next_ns = self._coarse_ns = self._started_ns = stamp_ns
        if self._looked_ns is None or stamp_ns >= self._next_ns:
            self._looked_ns = stamp_ns
            self._next_ns = stamp_ns + _ns(PERIOD_S)
            self._look(prepared(image), stamp_ns)
        return self.shift

    def _look(self, grey: Grey, stamp_ns: int) -> None:
        if self._patches is None:
            self._learn(grey, stamp_ns)
            return
        measured = self._measure(self._patches, grey, stamp_ns)
        self._agreed = 0
        if measured is not None:
            self._last, self._agreed = measured
            self._recent.append((stamp_ns, self._last))
        if not self._settled:
            self._settle(self._patches, stamp_ns)
            return
        oldest = stamp_ns - _ns(self._config.sustain_s)
        while self._recent and self._recent[0][0] <= oldest:
            self._recent.popleft()
        lasting = self._lasting()
        self._judge(lasting)
        if self.shift.state is ShiftState.MOVED:
            self._forget_kept(stamp_ns)
        elif lasting is not None and measured is not None:
            self._renew(self._patches, grey, stamp_ns)

    def _learn(self, grey: Grey, stamp_ns: int) -> None:
        """Take the median of the first time for the reference."""
        if not self._kept:
            self._image_size = grey.shape[1], grey.shape[0]
            self._started_ns = self._keep_ns = stamp_ns
        self._keep(grey, Motion(), stamp_ns)
        if stamp_ns - self._started_ns < self._learning_ns:
            return
        still, self._last = self._kept.median()
        self._patches, self._coarse = Patches(still, self._allowed), reduced(still)
        self._kept.clear()
        self._recent.clear()

    def _keep(self, grey: Grey, motion: Motion, stamp_ns: int) -> None:
        """Keep an image for the next reference, if it is time to."""
        if stamp_ns >= self._keep_ns:
            self._kept.add(grey, motion)
            self._keep_ns = stamp_ns + self._learning_ns // KEPT

    def _settle(self, patches: Patches, stamp_ns: int) -> None:
        """Take the median of some time for no shift; begin anew if too little was found."""
        settling_ns = stamp_ns - self._started_ns - _ns(self._config.settling_s)
        if settling_ns < 0:
            return
        if len(self._recent) < LEAST_MEASURES:
            if settling_ns >= _ns(self._config.sustain_s):
                self._patches = None
            return
        patches.rebase(median_motion([motion for _, motion in self._recent]))
        self._recent.clear()
        self._last = Motion()
        self._settled = True
        self._forget_kept(stamp_ns)

    def _renew(self, patches: Patches, grey: Grey, stamp_ns: int) -> None:
        """Exchange patches from time to time for ones of what stood still since."""
        self._keep(grey, self._last, stamp_ns)
        if stamp_ns >= self._renewal_ns and len(self._kept) > KEPT // 2:
            still, motion = self._kept.median()
            patches.renew(still, motion)
            self._coarse = reduced(still)
            self._forget_kept(stamp_ns)

    def _forget_kept(self, stamp_ns: int) -> None:
        self._kept.clear()
        self._renewal_ns = stamp_ns + _ns(RENEWAL_S)
        self._keep_ns = self._renewal_ns - self._learning_ns

    def _measure(self, patches: Patches, grey: Grey, stamp_ns: int) -> tuple[Motion, int] | None:
        """Return the motion: near the last or the lasting one, else near a coarse one."""
        guesses = [self._last]
        if self._distance(self._last, self._held) > CLOSE_PX:
            guesses.append(self._held)
        near = self._best(patches, grey, guesses, SEARCH_PX)
        if near is not None:
            self._coarse_wait_ns = COARSE_NS
            return near
        if not self._settled or stamp_ns < self._coarse_ns:
            return None
        self._coarse_ns = stamp_ns + self._coarse_wait_ns
        self._coarse_wait_ns = min(2 * self._coarse_wait_ns, LONGEST_COARSE_NS)
        scale = grey.shape[1] / self._coarse.shape[1]
        shifts = coarse_shifts(reduced(grey), self._coarse)
        coarse = [Motion(right * scale, down * scale) for right, down in shifts]
        return self._best(patches, grey, [self._held, *coarse], WIDE_SEARCH_PX)

    def _best(
        self, patches: Patches, grey: Grey, guesses: list[Motion], search_px: int
    ) -> tuple[Motion, int] | None:
        """Return the motion near one of some guesses on which most patches agree."""
        followed = [self._followed(patches, grey, guess, search_px) for guess in guesses]
        return max(filter(None, followed), key=lambda each: each[1], default=None)

    def _followed(
        self, patches: Patches, grey: Grey, guess: Motion, search_px: int
    ) -> tuple[Motion, int] | None:
        """Return the motion near a guess, searched again where it is until it stays."""
        found = None
        for _ in range(ROUNDS):
            found = patches.motion(grey, guess, search_px)
            if found is None or self._distance(found[0], guess) < CLOSE_PX:
                break
            guess = found[0]
        return found

    def _distance(self, one: Motion, other: Motion) -> float:
        return one.minus(other).size(self._image_size)

    def _lasting(self) -> Motion | None:
        """Return the median motion, if enough of the time is covered."""
        if len(self._recent) < LEAST_MEASURES:
            return None
        span = self._recent[-1][0] - self._recent[0][0]
        if span < LEAST_SPAN * _ns(self._config.sustain_s - PERIOD_S):
            return None
        return median_motion([motion for _, motion in self._recent])

    def _judge(self, lasting: Motion | None) -> None:
        """State what is known; an alarm stays until the image is seen to be back."""
        moved = self.shift.state is ShiftState.MOVED
        if lasting is None:
            if not self._recent and not moved:
                self.shift = CameraShift(ShiftState.UNKNOWN, noise_px=UNKNOWN_PX)
            return
        self._held, size = lasting, lasting.size(self._image_size)
        limit = self._config.threshold_px * (END_SHARE if moved else 1.0)
        moved = size >= limit
        self.shift = CameraShift(
            ShiftState.MOVED if moved else ShiftState.STILL,
            size,
            lasting.right,
            lasting.down,
            float(np.degrees(np.arctan2(lasting.turn, 1 + lasting.zoom))),
            self._agreed,
            size if moved else 0.0,
        )


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)
