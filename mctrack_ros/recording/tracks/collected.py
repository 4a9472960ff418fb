"""Tracks that are written when all of them are known."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import REPORTED, ClassCode, Tracks
from mctrack_ros.recording.closing import Closing
from mctrack_ros.recording.tables.columns import TableError, read_lines
from mctrack_ros.recording.tracks.pitch import Pitch

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

_COLUMNS = ('track_id', 'position', 'velocity', 'class_id', 'kit')


@dataclass(frozen=True, slots=True)
class Layout:
    """
    How a file of tracks is laid out.

    Attributes
    ----------
    period_ns : int
        Period of its frames, ns.
    origin_ns : int
        Where frame 1 begins, ns.
    origin : (float, float)
        Origin of the positions of tracks in the coordinates of files, m.
    frame_id : str
        Frame of the positions.
    pitch : Pitch, optional
        Of sports formats, in the coordinates of files.
    away : frozenset of int, optional
        Ids of the away team; unless given, whoever wears the second most frequent clothing.

    """

    period_ns: int
    origin_ns: int = 0
    origin: tuple[float, float] = (0.0, 0.0)
    frame_id: str = 'map'
    pitch: Pitch | None = None
    away: frozenset[int] | None = None

    @property
    def rate_hz(self) -> float:
        """Frames a second."""
        return round(1e9 / self.period_ns, 3)

    def frame(self, stamp_ns: Ints) -> Ints:
        """Return frames, from 1, of stamps, ns."""
        return (stamp_ns - self.origin_ns) // self.period_ns + 1

    def stamp_ns(self, frame: Ints) -> Ints:
        """Return the middles, ns, of frames."""
        return self.origin_ns + (frame - 1) * self.period_ns + self.period_ns // 2

    def on_pitch(self) -> Pitch:
        """Return the pitch; TableError: there is none."""
        if self.pitch is None:
            raise TableError(
                'the format measures from the centre spot of a pitch: name a site with its area, '
                'or the pitch: --pitch x0,y0,x1,y1'
            )
        return self.pitch

    def pitch_of(self, length: float, width: float) -> Pitch:
        """Return the pitch; unless there is one, one of these sides, m, a corner the origin."""
        return self.pitch or Pitch((length / 2, width / 2), length, width)


@dataclass(frozen=True, eq=False, slots=True)
class Collected:
    """
    All rows of a file, in the order of time.

    Attributes
    ----------
    stamp_ns, track_id : (n,) int64 array
        Stamps, ns, and ids.
    position : (n, 3) float64 array
        In the coordinates of files, m.
    velocity : (n, 2) float64 array
        m/s.
    class_id, kit : (n,) int64 array
        A `ClassCode`, and the cluster of clothing.

    """

    stamp_ns: Ints
    track_id: Ints
    position: Floats
    velocity: Floats
    class_id: Ints
    kit: Ints

    def __len__(self) -> int:
        """Return how many they are."""
        return len(self.stamp_ns)

    def by_track(self) -> dict[int, NDArray[np.intp]]:
        """Return the rows of each track, in the order of time."""
        order = np.argsort(self.track_id, kind='stable')
        if not len(order):
            return {}
        parts = np.split(order, np.flatnonzero(np.diff(self.track_id[order])) + 1)
        return {int(self.track_id[part[0]]): part for part in parts}

    def class_of(self, part: NDArray[np.intp]) -> ClassCode:
        """Return the latest class of a track that is known."""
        known = self.class_id[part][self.class_id[part] != 0]
        return ClassCode(int(known[-1])) if len(known) else ClassCode.UNKNOWN


class CollectingWriter(Closing):
    """
    Collect the confirmed, coasting and grouped tracks; write them when it is closed.

    Parameters
    ----------
    path : str or Path
        The file, replaced if it is there; its parents are made.
    layout : Layout
        How it is laid out.

    """

    def __init__(self, path: str | Path, layout: Layout) -> None:
        self._path, self._layout = Path(path), layout
        self._stamps: list[tuple[int, int]] = []
        self._parts: list[list[NDArray[Any]]] = []
        self._path.parent.mkdir(parents=True, exist_ok=True)

    def write(self, rows: Tracks) -> None:
        """Append one instant."""
        reported = rows.select(np.isin(rows.status, REPORTED))
        if len(reported):
            self._stamps.append((rows.stamp_ns, len(reported)))
            self._parts.append([getattr(reported, name) for name in _COLUMNS])

    def close(self) -> None:
        """Write the files."""
        stamps = np.array(self._stamps, np.int64).reshape(-1, 2)
        empty = [Tracks.NONE[list(Tracks.COLUMNS).index(name)] for name in _COLUMNS]
        columns = [np.concatenate(parts) for parts in zip(empty, *self._parts)]
        ids, position, velocity, class_id, kit = columns
        shifted = position.astype(np.float64) + np.array([*self._layout.origin, 0.0])
        self._finish(
            Collected(
                np.repeat(stamps[:, 0], stamps[:, 1]),
                ids.astype(np.int64),
                shifted,
                velocity.astype(np.float64),
                class_id.astype(np.int64),
                kit.astype(np.int64),
            )
        )

    @abstractmethod
    def _finish(self, rows: Collected) -> None:
        """Write all rows."""


def rows_of_lines(
    path: Path, read: Callable[[str], Iterable[tuple[float, ...]]]
) -> list[tuple[float, ...]]:
    """
    Return the rows of a text, of which a function returns those of each line that is not blank.

    Raises
    ------
    TableError
        If the file cannot be read, or the function raises `ValueError`; names file and line.

    """
    rows: list[tuple[float, ...]] = []
    for number, line in enumerate(read_lines(path), 1):
        if line.strip():
            try:
                rows += read(line.strip())
            except ValueError as error:
                raise TableError(f'{path}, line {number}: {error}') from error
    return rows


def instants_on_pitch(
    stamp_ns: Ints, track_id: Ints, place: Floats, ball_id: int, pitch: Pitch, layout: Layout
) -> list[Tracks]:
    """
    Return people and the ball as tracks, instant by instant.

    Parameters
    ----------
    stamp_ns, track_id : (n,) int64 array
        When each row is, ns, and of whom.
    place : (n, 3) array
        Where, m from the centre spot.
    ball_id : int
        Id of the ball.
    pitch : Pitch
        Where the centre spot is.
    layout : Layout
        Of the origin.

    """
    columns = {
        'track_id': track_id,
        'position': np.column_stack([pitch.to_ground(place[:, :2]), place[:, 2]]),
        'class_id': np.where(track_id == ball_id, ClassCode.BALL, ClassCode.PERSON),
    }
    return instants_of(stamp_ns, columns, layout.origin)


def instants_of(
    stamp_ns: Ints, columns: dict[str, Any], origin: tuple[float, float]
) -> list[Tracks]:
    """
    Return rows of a file as tracks, instant by instant.

    Parameters
    ----------
    stamp_ns : (n,) int64 array
        When each row is, ns; in any order.
    columns : dict of str to array_like
        Columns of `Tracks`, positions in the coordinates of files, (n, 3) m.
    origin : (float, float)
        Origin of the returned positions, m.

    Raises
    ------
    TableError
        If an id stands twice in an instant.

    """
    order = np.lexsort([np.asarray(columns['track_id']), stamp_ns])
    stamps = stamp_ns[order]
    given = {name: np.asarray(values)[order] for name, values in columns.items()}
    given['position'] = given['position'] - [*origin, 0.0]
    ids = given['track_id']
    twice = (np.diff(stamps) == 0) & (np.diff(ids.astype(np.int64)) == 0)
    if twice.any():
        row = int(np.flatnonzero(twice)[0])
        raise TableError(f'track {ids[row]} stands twice at {stamps[row] * 1e-9:.3f} s')
    cuts = [0, *(np.flatnonzero(np.diff(stamps)) + 1).tolist(), len(stamps)]
    return [
        Tracks.build(
            int(stamps[first]), **{name: values[first:last] for name, values in given.items()}
        )
        for first, last in pairwise(cuts)
        if last > first
    ]
