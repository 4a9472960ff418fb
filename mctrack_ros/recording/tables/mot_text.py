"""
MOT text on the ground plane: ``frame,id,-1,-1,-1,-1,score,x,y,z``, frames from 1.

The format of the MOTChallenge benchmarks with their box fields left open, positions in metres.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from mctrack_ros.interfaces import REPORTED, Tracks

_FIELDS = 10


class MotTextError(ValueError):
    """A file that is not MOT text with ground positions; names file, line and reason."""


class MotTextWriter:
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
        What the tracks' positions are told from: the file has positions in its coordinates, m.

    """

    def __init__(
        self,
        path: str | Path,
        period_ns: int,
        origin_ns: int | None = None,
        origin: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self._period_ns, self._origin = period_ns, origin
        self._origin_ns = origin_ns
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        self._file = Path(path).open('w', newline='\n')  # noqa: SIM115

    def write(self, rows: Tracks) -> None:
        """Append one instant; its frame is the period that its stamp falls in."""
        if self._origin_ns is None:
            self._origin_ns = frame_origin_ns(rows.stamp_ns, self._period_ns)
        frame = (rows.stamp_ns - self._origin_ns) // self._period_ns + 1
        reported = rows.select(np.isin(rows.status, REPORTED))
        self._file.writelines(_lines(frame, reported, self._origin))

    def close(self) -> None:
        """Finish the file."""
        self._file.close()

    def __enter__(self) -> Self:
        """Return the writer itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Finish the file."""
        self.close()


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
        What the positions that are returned are told from, m.

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


def frame_origin_ns(stamp_ns: int, period_ns: int) -> int:
    """Return where the period begins whose middle is the stamp, for stamps of any phase."""
    return stamp_ns - period_ns // 2


def _lines(frame: int, rows: Tracks, origin: tuple[float, float]) -> Iterator[str]:
    position = rows.position + np.array([*origin, 0.0])
    for track_id, score, (x, y, z) in zip(
        rows.track_id.tolist(), rows.score.tolist(), position.tolist()
    ):
        yield f'{frame},{track_id},-1,-1,-1,-1,{score:.3f},{x:.4f},{y:.4f},{z:.4f}\n'


def _rows(path: str | Path) -> Iterator[list[float]]:
    """Yield the numbers of the lines."""
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
