"""The field of view of a grid file, changed in its place: everything else stays as it stands."""

from __future__ import annotations

from pathlib import Path
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.errors import GridError
from mctrack_ros.ground.grid.file import read_grid
from mctrack_ros.ground.xml_files import tag

Floats = NDArray[np.float64]
_BLANK = b' \t'


def write_fov(fov: Floats | None, path: str | Path) -> None:
    """
    Write a field of view into a grid file, byte for byte the same otherwise.

    What a person wrote stays: comments, ids of cells, order of attributes, how numbers stand.

    Parameters
    ----------
    fov : (k, 2) array or None
        Corners on the ground, m; None: the file is to have none.
    path : str or Path
        The file.

    Raises
    ------
    GridError
        If the file is no grid that can be read, or no text of one byte a letter.

    """
    read_grid(path)
    content = Path(path).read_bytes()
    places = _Places(content)
    if not content.startswith(b'</', places.end):
        raise GridError(f'{path}: save it as UTF-8, so that a field of view can be written')
    newline = b'\r\n' if b'\r\n' in content else b'\n'
    indent = content[_line_start(content, places.cell) : places.cell] or b'  '
    element = b'' if fov is None else newline.join(_lines(fov, indent))
    if places.fov:
        start, end = places.fov if element else _whole_lines(content, *places.fov)
    else:
        start = end = _line_start(content, places.end)
        element = element and indent + element + newline
        if start == places.end and not content[:start].endswith(b'\n'):
            element = element and newline + element
    Path(path).write_bytes(content[:start] + element + content[end:])


class _Places:
    """Where the first cell, the field of view and the root's end stand in a file, bytes."""

    def __init__(self, content: bytes) -> None:
        self.cell = self.end = -1
        self.fov: tuple[int, int] | tuple[()] = ()
        self._fov_start = 0
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._started
        self._parser.EndElementHandler = self._ended
        self._parser.Parse(content, True)
        if self.fov:
            self.fov = self.fov[0], content.index(b'>', self.fov[1]) + 1

    def _started(self, name: str, _: dict[str, str]) -> None:
        at = self._parser.CurrentByteIndex
        if name == 'cell' and self.cell < 0:
            self.cell = at
        if name == 'fov':
            self._fov_start = at

    def _ended(self, name: str) -> None:
        at = self._parser.CurrentByteIndex
        if name == 'fov':
            self.fov = self._fov_start, at
        if name == 'workstation':
            self.end = at


def _lines(fov: Floats, indent: bytes) -> list[bytes]:
    corners = [tag('corner', xr=x, yr=y).encode() for x, y in fov.tolist()]
    return [b'<fov>', *(indent * 2 + corner for corner in corners), indent + b'</fov>']


def _line_start(content: bytes, at: int) -> int:
    """Return where the line begins of which only blanks stand before a place; else the place."""
    start = len(content[:at].rstrip(_BLANK))
    return start if content[:start].endswith(b'\n') else at


def _whole_lines(content: bytes, start: int, end: int) -> tuple[int, int]:
    """Return the lines that hold nothing but a span; where they hold more, the span."""
    begin, after = _line_start(content, start), content.find(b'\n', end) + 1
    alone = content[:begin].endswith(b'\n') and after and not content[end:after].strip()
    return (begin, after) if alone else (start, end)
