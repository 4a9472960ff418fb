"""What the record of the ticks says was late, missing or without feedback."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Ticks

COUNTS = ('admitted', 'detections', 'late', 'dropped_detections', 'missing', 'feedback_missed')


@dataclass(frozen=True, eq=False, slots=True)
class Drops:
    """
    Counts by tick and camera, and when.

    Attributes
    ----------
    seconds : (t,) float64 array
        Time of the ticks since the start, s.
    counts : dict of str to (t, c) int64 array
        By name in ``COUNTS``: messages and detections admitted; messages late and their
        detections; cameras that did not report; images without feedback.

    """

    seconds: NDArray[np.float64]
    counts: dict[str, NDArray[np.int64]]

    def per_camera(self, name: str, start_s: float = 0.0) -> NDArray[np.int64]:
        """Return a count's sum for each camera, (c,), from a time on."""
        return np.asarray(self.counts[name][self.seconds >= start_s].sum(axis=0), np.int64)

    def late_ticks(self, start_s: float = 0.0) -> int:
        """Return how many ticks from a time on had anything late."""
        return int(self.counts['late'][self.seconds >= start_s].any(axis=1).sum())

    def total(self, name: str, start_s: float = 0.0) -> int:
        """Return a count's sum over the cameras, from a time on."""
        return int(self.per_camera(name, start_s).sum())


def drops_of(ticks: Sequence[Ticks], start_ns: int, cameras: int) -> Drops:
    """
    Lay the rows of the ticks out by camera.

    Parameters
    ----------
    ticks : sequence of Ticks
        The record.
    start_ns : int
        When time is 0, ns.
    cameras : int
        Number of cameras.

    """
    counts = {name: np.zeros((len(ticks), cameras), np.int64) for name in COUNTS}
    for index, rows in enumerate(ticks):
        for name, table in counts.items():
            table[index, rows.camera] = getattr(rows, name)
    stamps = np.array([rows.stamp_ns for rows in ticks], np.int64)
    seconds = np.asarray((stamps - start_ns) * 1e-9, np.float64)
    return Drops(seconds, counts)
