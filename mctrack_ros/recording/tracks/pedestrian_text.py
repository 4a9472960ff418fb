"""
Trajectories of pedestrian research: ``id frame x y`` in metres, the frame rate in the header.

The text format of JuPedSim and the Pedestrian Dynamics Data Archive, which PedPy reads.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode, Tracks
from mctrack_ros.recording.tables.columns import TableError, read_lines
from mctrack_ros.recording.tracks.collected import Layout, instants_of
from mctrack_ros.recording.tracks.track_writer import TrackWriter


class PedestrianTextWriter(TrackWriter):
    """Write the text; a comment beyond the format says when its frame 0 was."""

    def __init__(self, path: str | Path, layout: Layout) -> None:
        seconds, rest = divmod(int(layout.stamp_ns(np.array(1))), 10**9)
        self.HEADER = (
            f'# framerate: {layout.rate_hz:g}\n'
            f'# began: {seconds}.{rest:09d}\n'
            '# id frame x/m y/m z/m\n'
        )
        super().__init__(path, layout.period_ns, layout.origin_ns, layout.origin)

    def _lines(self, frame: int, rows: Tracks, position: NDArray[np.float64]) -> Iterator[str]:
        for track_id, (x, y, z) in zip(rows.track_id.tolist(), position.tolist()):
            yield f'{track_id} {frame - 1} {x:.4f} {y:.4f} {z:.4f}\n'


def read_pedestrian_text(path: str | Path, layout: Layout) -> list[Tracks]:
    """
    Read the text; in metres, or centimetres if its header says so.

    The frame rate is that of the header, or else that of the layout; the beginning as well.

    Raises
    ------
    TableError
        If it cannot be used; names file, line and reason.

    """
    scale, period_ns, origin_ns = 1.0, layout.period_ns, layout.origin_ns
    rows: list[tuple[float, ...]] = []
    for number, line in enumerate(read_lines(path), 1):
        if line.startswith('#'):
            rate = re.search(r'framerate\D*([\d.]+)', line)
            began = re.search(r'began: (\d+\.\d{9})$', line)
            if rate:
                period_ns = round(1e9 / _positive(rate[1], path, number))
            if began:
                origin_ns = int(Decimal(began[1]) * 10**9)
            if re.search(r'\b(x/cm|in cm)\b', line.lower()):
                scale = 0.01
        elif line.strip():
            rows.append(_row(line, path, number))
    if not rows:
        return []
    table = np.array(rows)
    stamps = origin_ns + table[:, 1].astype(np.int64) * period_ns
    columns = {
        'track_id': table[:, 0],
        'position': table[:, 2:] * scale,
        'class_id': np.full(len(table), ClassCode.PERSON),
    }
    return instants_of(stamps, columns, layout.origin)


def _row(line: str, path: str | Path, number: int) -> tuple[float, ...]:
    """Return id, frame, x, y and z."""
    try:
        values = [float(text) for text in line.split()]
    except ValueError as error:
        raise TableError(f'{path}, line {number}: {error}') from error
    if len(values) < 4 or not np.isfinite(values[:5]).all():
        raise TableError(f'{path}, line {number}: expected id, frame, x, y and perhaps z')
    for name, value in zip(('id', 'frame'), values):
        if value % 1 or not 0 <= value < 2**32:
            raise TableError(
                f'{path}, line {number}: the {name} is {value:g}, expected a whole number from 0'
            )
    return (*values[:4], values[4] if len(values) > 4 else 0.0)


def _positive(text: str, path: str | Path, number: int) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not value > 0:
        raise TableError(f'{path}, line {number}: the frame rate is {text}')
    return value
