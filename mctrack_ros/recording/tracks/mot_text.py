"""
MOT text on the ground plane: ``frame,id,-1,-1,-1,-1,score,x,y,z``, frames from 1.

The format of the MOTChallenge benchmarks with their box fields left open, positions in metres.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.input_size import TABLE, check_size
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording.tracks.track_writer import TrackWriter

_FIELDS = 10


class MotTextError(ValueError):
    """A file that is not MOT text with ground positions; names file, line and reason."""


class MotTextWriter(TrackWriter):
    """Write MOT text."""

    def _lines(self, frame: int, rows: Tracks, position: NDArray[np.float64]) -> Iterator[str]:
        for track_id, score, (x, y, z) in zip(
            rows.track_id.tolist(), rows.score.tolist(), position.tolist()
        ):
            yield f'{frame},{track_id},-1,-1,-1,-1,{score:.3f},{x:.4f},{y:.4f},{z:.4f}\n'


def write_mot_text(
    path: str | Path, instants: Iterable[Tracks], period_ns: int, origin_ns: int | None = None
) -> None:
    """Write all instants with a `MotTextWriter`."""
    with MotTextWriter(path, period_ns, origin_ns) as writer:
        for rows in instants:
            writer.write(rows)


def read_mot_text(
    path: str | Path,
    period_ns: int,
    origin_ns: int = 0,
    origin: tuple[float, float] = (0.0, 0.0),
) -> list[Tracks]:
    """
    Read tracks, or truth in the same format.

    Parameters
    ----------
    path : str or Path
        The file.
    period_ns : int
        Period of the frames, ns.
    origin_ns : int
        Where frame 1 begins, ns.
    origin : (float, float)
        Origin of the returned positions, m.

    Returns
    -------
    list of Tracks
        One for each frame that has rows, ascending, stamped with the middle of its period.

    Raises
    ------
    MotTextError
        If the file is not there or a line does not hold what it should.

    """
    rows = sorted(_rows(path), key=lambda row: row[0])
    return [
        _instant(list(group), origin_ns + (int(frame) - 1) * period_ns + period_ns // 2, origin)
        for frame, group in groupby(rows, key=lambda row: row[0])
    ]


def mot_text_place(path: str | Path) -> tuple[float, float] | None:
    """Return the first position in a file, m; None if it has none. Raises as `read_mot_text`."""
    return next(((row[7], row[8]) for row in _rows(path)), None)


def _rows(path: str | Path) -> Iterator[list[float]]:
    """Yield the numbers of the lines."""
    check_size(path, TABLE, MotTextError)
    try:
        lines = Path(path).read_text().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise MotTextError(f'{path} cannot be read: {error}') from error
    for number, line in enumerate(lines, 1):
        if line.strip():
            yield _row(path, number, line)


def _row(path: str | Path, number: int, line: str) -> list[float]:
    """Return the numbers of a line."""
    try:
        values = [float(text) for text in line.split(',')]
    except ValueError as error:
        raise MotTextError(f'{path}, line {number}: {error}') from error
    if len(values) != _FIELDS:
        raise MotTextError(f'{path}, line {number}: {len(values)} fields, expected {_FIELDS}')
    if not all(map(math.isfinite, values)):
        raise MotTextError(f'{path}, line {number}: a number is not finite')
    for name, value, least in (('frame', values[0], 1), ('id', values[1], 0)):
        if value % 1 or not least <= value < 2**32:
            raise MotTextError(
                f'{path}, line {number}: the {name} is {value:g}, expected a whole number '
                f'from {least}'
            )
    return values


def _instant(rows: list[list[float]], stamp_ns: int, origin: tuple[float, float]) -> Tracks:
    table = np.array(rows)
    position = table[:, 7:10] - [*origin, 0.0]
    return Tracks.build(stamp_ns, track_id=table[:, 1], score=table[:, 6], position=position)
