"""Feedback that waits until it is as old as the design says, so that images replay exactly."""

from __future__ import annotations

from dataclasses import replace
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import (
    LARGEST_DISTANCE,
    LARGEST_EXTENT,
    LARGEST_SPEED,
    LARGEST_VARIANCE,
    Feedback,
    Rows,
)

R = TypeVar('R', bound=Rows)
KEPT_TICKS = 64  # 2.5 s at 25 Hz
FULL = 1.001
"""A bin of a template, which is a share, is no more, but for rounding."""


class RowsBuffer(Generic[R]):
    """
    The camera's store of feedback: for each image that which is `delay_ns` old.

    Parameters
    ----------
    period_ns : int
        Length of a tick, ns.
    delay_ns : int
        Age of the feedback to use, ns.

    Raises
    ------
    ValueError
        If the period is not positive or the delay negative.

    """

    def __init__(self, period_ns: int, delay_ns: int) -> None:
        if period_ns <= 0 or delay_ns < 0:
            raise ValueError(
                f'period_ns is {period_ns!r} and delay_ns {delay_ns!r}, '
                'expected a positive and a non-negative number'
            )
        self._period_ns, self._delay_ns = int(period_ns), int(delay_ns)
        self._by_tick: dict[int, R] = {}
        self._first_stamp_ns: int | None = None

    def push(self, feedback: R) -> int:
        """
        Store feedback under the tick it was made from; the oldest makes room.

        Returns how many of its rows are left out.
        """
        self._by_tick[feedback.stamp_ns // self._period_ns] = feedback
        while len(self._by_tick) > KEPT_TICKS:
            self._forget(next(iter(self._by_tick)))
        return 0

    def select(self, stamp_ns: int) -> tuple[R | None, bool]:
        """
        Return the feedback for an image, and whether it should be there but is not.

        Parameters
        ----------
        stamp_ns : int
            The image's stamp, ns.

        Returns
        -------
        feedback : Rows or None
            That of the tick in which the stamp less the delay falls.
        missed : bool
            True where there is none although the first images' ticks could have made it.

        """
        if self._first_stamp_ns is None or stamp_ns < self._first_stamp_ns:
            self._first_stamp_ns = stamp_ns
        wanted = (stamp_ns - self._delay_ns) // self._period_ns
        feedback = self._by_tick.get(wanted)
        if feedback is not None:
            feedback = self._with_changes(feedback, wanted)
        possible = wanted >= self._first_stamp_ns // self._period_ns
        return feedback, feedback is None and possible

    def _with_changes(self, feedback: R, tick: int) -> R:
        """Return the feedback of a tick as an image gets it."""
        return feedback

    def _forget(self, tick: int) -> None:
        """Drop the feedback of a tick."""
        del self._by_tick[tick]


class FeedbackBuffer(RowsBuffer[Feedback]):
    """
    The same for predictions of targets: impossible ones are left out, ids corrected once.

    Corrections of ids are given once, though several images of a fast camera fall in a tick; a
    slow one gets those of the ticks between, too.

    Parameters
    ----------
    period_ns, delay_ns : int
        See `RowsBuffer`.

    """

    def __init__(self, period_ns: int, delay_ns: int) -> None:
        super().__init__(period_ns, delay_ns)
        self._pending_corrections: dict[int, dict[int, int]] = {}

    def push(self, feedback: Feedback) -> int:
        """Store feedback; return how many rows are left out, because no target can be so."""
        given, feedback = len(feedback), feedback.select(is_sound(feedback))
        self._pending_corrections[feedback.stamp_ns // self._period_ns] = feedback.corrections()
        return given - len(feedback) + super().push(feedback)

    def _with_changes(self, feedback: Feedback, tick: int) -> Feedback:
        origin = self._take_corrections(tick)
        previous = [origin.get(track_id, 0) for track_id in feedback.track_id.tolist()]
        return replace(feedback, previous_id=np.array(previous, np.uint32))

    def _forget(self, tick: int) -> None:
        super()._forget(tick)
        self._pending_corrections.pop(tick, None)

    def _take_corrections(self, last: int) -> dict[int, int]:
        """Return what ids were before corrections not yet given, up to a tick; forget these."""
        origin: dict[int, int] = {}
        for tick in sorted(tick for tick in self._pending_corrections if tick <= last):
            changed = self._pending_corrections.pop(tick)
            known = {new: old for new, old in origin.items() if new not in changed}
            origin = known | {new: origin.get(old, old) for old, new in changed.items()}
        return {new: old for new, old in origin.items() if new != old}


def is_sound(feedback: Feedback) -> NDArray[np.bool_]:
    """
    Tell which rows, (n,), can be targets: places, speeds, sizes and colours that are possible.

    Positions and velocities are bounded, no two components of the state are correlated by 1 or
    more, sizes are above 0 where they are known, bins of templates from 0 to 1.
    """
    sound = (np.abs(feedback.position[:, :2]) < LARGEST_DISTANCE).all(axis=1)
    sound &= (np.abs(feedback.velocity[:, :2]) < LARGEST_SPEED).all(axis=1)
    size, template = feedback.extent, feedback.template
    sound &= (np.isnan(size) | ((size > 0.0) & (size < LARGEST_EXTENT))).all(axis=1)
    sound &= ((template >= 0.0) & (template <= FULL)).all(axis=1)
    covariance = feedback.covariance.astype(np.float64)
    own = covariance.diagonal(axis1=1, axis2=2)
    sound &= ((own > 0.0) & (own < LARGEST_VARIANCE)).all(axis=1)
    one, other = np.triu_indices(4, 1)
    sound &= (covariance[:, one, other] ** 2 < own[:, one] * own[:, other]).all(axis=1)
    return np.asarray(sound)
