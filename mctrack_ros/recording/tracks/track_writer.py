"""Tracks, or truth, as lines of text, one instant at a time."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import REPORTED, Tracks
from mctrack_ros.recording.closing import Closing

_NEARLY_WHOLE = 0.01
"""A measured rate that is so near a whole number, as a share, is meant to be it."""


class TrackWriter(Closing):
    """
    Write the confirmed, coasting and grouped tracks, one instant at a time.

    Parameters
    ----------
    path : str or Path
        The file, replaced if it is there; its parents are made.
    period_ns : int
        Period of the ticks, ns.
    origin_ns : int, optional
        Where frame 1 begins, ns; by default half a period before the first instant.
    origin : (float, float)
        Origin of the positions; the file has them in the coordinates of the site's files, m.

    """

    HEADER = ''

    def __init__(
        self,
        path: str | Path,
        period_ns: int,
        origin_ns: int | None = None,
        origin: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self._period_ns, self._origin_ns, self._origin = period_ns, origin_ns, origin
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        self._file = Path(path).open('w', newline='\n')  # noqa: SIM115
        self._file.write(self.HEADER)

    def write(self, rows: Tracks) -> None:
        """Append one instant; its frame is the period that its stamp falls in."""
        if self._origin_ns is None:
            self._origin_ns = frame_origin_ns(rows.stamp_ns, self._period_ns)
        frame = (rows.stamp_ns - self._origin_ns) // self._period_ns + 1
        reported = rows.select(np.isin(rows.status, REPORTED))
        position = reported.position + np.array([*self._origin, 0.0])
        self._file.writelines(self._lines(frame, reported, position))

    @abstractmethod
    def _lines(self, frame: int, rows: Tracks, position: NDArray[np.float64]) -> Iterator[str]:
        """Yield the line of each track, with its position, (n, 3), in the file's coordinates."""

    def close(self) -> None:
        """Finish the file."""
        self._file.close()


def frame_origin_ns(stamp_ns: int, period_ns: int) -> int:
    """Return where the period begins whose middle is the stamp, for stamps of any phase."""
    return stamp_ns - period_ns // 2


class Frames:
    """
    Give instants their frames, and count what that costs.

    Parameters
    ----------
    rate_hz : float
        Frames a second.
    began_ns : int
        The middle of frame 1, ns.

    Attributes
    ----------
    moved_ns : int
        The farthest that an instant was moved, ns.
    left_out : int
        Instants whose frame another had already.

    """

    def __init__(self, rate_hz: float, began_ns: int) -> None:
        self.rate_hz, self.period_ns = rate_hz, round(1e9 / rate_hz)
        self.origin_ns = frame_origin_ns(began_ns, self.period_ns)
        self.moved_ns = self.left_out = 0
        self._last = -(2**63)

    def admits(self, stamp_ns: int) -> bool:
        """Tell whether the frame of an instant is free; count if it is not."""
        frame, since_ns = divmod(stamp_ns - self.origin_ns, self.period_ns)
        if frame <= self._last:
            self.left_out += 1
            return False
        self._last = frame
        self.moved_ns = max(self.moved_ns, abs(since_ns - self.period_ns // 2))
        return True


def frame_rate(interval_ns: float, *, whole: bool) -> float:
    """
    Return the frame rate for instants at an interval, ns.

    Where it must be a whole number, the next higher one: no two instants share a frame.
    """
    rate = 1e9 / interval_ns
    nearest = float(max(1, round(rate)))
    if abs(rate - nearest) <= _NEARLY_WHOLE * rate:
        return nearest
    return float(math.ceil(rate)) if whole else round(rate, 3)
