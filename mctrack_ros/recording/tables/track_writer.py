"""Tracks, or truth, as lines of text, one instant at a time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import REPORTED, Tracks
from mctrack_ros.recording.closing import Closing


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
