"""Tracks, or truth, of any file that `mctrack evaluate` takes, instant by instant."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from mctrack_ros.evaluation import Trajectories
from mctrack_ros.evaluation.common_origin import moved_to
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import (
    BagError,
    BagReader,
    frame_origin_ns,
    is_bag,
    read_mot_text,
    stated_origin,
)
from mctrack_ros.recording.tables.columns import ABSOLUTE_NS, has_header, read_lines
from mctrack_ros.recording.tracks.track_table import read_track_table
from mctrack_ros.site.stated_origin import Origin

TRUTH_TOPIC = '/truth/tracks'
TRACKS_TOPIC = '/tracks'
FRAME_NS = 40_000_000
"""Length of a frame where nothing says how long it is, ns."""


@dataclass(frozen=True, eq=False, slots=True)
class Recording:
    """
    The instants of a bag, of MOT text or of a table with a header.

    Attributes
    ----------
    instants : tuple of Tracks
        Ascending.
    period_ns : int
        Time between instants, ns.
    is_text : bool
        Whether rows of score 0 are not to be counted, as in the MOTChallenge's truth.
    counts_frames : bool
        Whether the file has frames instead of times.
    frames : tuple of int
        Number of each instant, from 1, where a table has frames beside times; else empty.

    """

    instants: tuple[Tracks, ...]
    period_ns: int
    is_text: bool = False
    counts_frames: bool = False
    frames: tuple[int, ...] = ()

    @property
    def is_absolute(self) -> bool:
        """Whether instants have stamps; those of text may count from a beginning of its own: 0."""
        if not self.instants:
            return False
        return not self.is_text or self.instants[0].stamp_ns >= ABSOLUTE_NS

    def origin_ns(self) -> int:
        """Return where the first frame begins, ns."""
        if not self.is_absolute:
            return 0
        return frame_origin_ns(self.instants[0].stamp_ns, self.period_ns)

    def begin_ns(self) -> int:
        """Return the time from which seconds are counted: the first instant, or frame 1, or 0."""
        if self.is_absolute:
            return self.instants[0].stamp_ns
        return self.period_ns // 2 if self.counts_frames else 0

    def by_frames(self) -> Self:
        """Return the same instants at their frames, of the period found from their times."""
        count = self.frames[-1] - self.frames[0]
        span_ns = self.instants[-1].stamp_ns - self.instants[0].stamp_ns
        period_ns = round(span_ns / count) if count else self.period_ns
        moved = tuple(
            dataclasses.replace(rows, stamp_ns=(frame - 1) * period_ns + period_ns // 2)
            for rows, frame in zip(self.instants, self.frames)
        )
        return dataclasses.replace(
            self, instants=moved, period_ns=period_ns, counts_frames=True, frames=()
        )

    def with_period(self, period_ns: int) -> Self:
        """Return the same frames, so long, ns."""
        moved = [
            dataclasses.replace(
                rows, stamp_ns=rows.stamp_ns // self.period_ns * period_ns + period_ns // 2
            )
            for rows in self.instants
        ]
        return dataclasses.replace(self, instants=tuple(moved), period_ns=period_ns)

    def trajectories(self, period_ns: int, origin_ns: int) -> Trajectories:
        """
        Return the rows in frames of a period that begin at an origin, ns.

        Raises
        ------
        ValueError
            If an id stands twice in a frame.

        """
        if not self.is_absolute:
            origin_ns = 0
        return Trajectories.from_tracks(self.instants, period_ns, origin_ns)


def read_instants(
    path: str | Path,
    topics: tuple[str, ...],
    rate_hz: float | None = None,
    origin: Origin | None = None,
) -> Recording:
    """
    Read the first of some topics that a bag has, or text.

    Parameters
    ----------
    path : str or Path
        A bag's folder, or a file: MOT text with ground positions, or a table with a header.
    topics : tuple of str
        Which hold `Tracks`, the preferred first.
    rate_hz : float, optional
        Frames a second of text that counts frames.
    origin : (float, float), optional
        Origin of positions, m; unless given, that of the bag, and zero for text.

    Raises
    ------
    BagError, MotTextError, TableError
        If the file cannot be read, or holds none of the topics.

    """
    frame_ns = round(1e9 / rate_hz) if rate_hz else FRAME_NS
    if Path(path).is_file() and not is_bag(path):
        if not has_header(read_lines(path)):
            text = read_mot_text(path, frame_ns, origin=origin or (0.0, 0.0))
            return Recording(tuple(text), frame_ns, is_text=True, counts_frames=True)
        rows, frames, counts_frames = read_track_table(path, frame_ns, origin or (0.0, 0.0))
        period_ns = frame_ns if counts_frames else _period_ns(rows)
        return Recording(tuple(rows), period_ns, True, counts_frames, tuple(frames))
    with BagReader(path) as reader:
        present = [topic for topic in topics if topic in reader.topics]
        if not present:
            raise BagError(f'{path} has no topic {" or ".join(topics)}')
        instants = [rows for rows, _ in reader.rows(present[0], Tracks)]
        instants = moved_to(instants, stated_origin(reader), origin)
    instants.sort(key=lambda rows: rows.stamp_ns)
    return Recording(tuple(instants), _period_ns(instants))


def _period_ns(instants: list[Tracks]) -> int:
    stamps = [rows.stamp_ns for rows in instants]
    return int(np.median(np.diff(stamps))) if len(stamps) > 1 else FRAME_NS
