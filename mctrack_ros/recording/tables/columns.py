"""Text tables with a header: columns by any of their usual names, errors with their lines."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.input_size import TABLE, check_size

Floats = NDArray[np.float64]
Spellings = Mapping[str, tuple[str, ...]]

ABSOLUTE_NS = 10**17
"""Stamps from here on count from 1970; earlier ones from a beginning of their own."""

TIMES: Spellings = {
    'time': ('time_s', 't', 't_s', 'timestamp', 'timestamp_s', 'stamp', 'seconds', 'sec'),
    'time_ms': ('t_ms', 'timestamp_ms', 'milliseconds'),
    'time_us': ('t_us', 'timestamp_us', 'microseconds'),
    'time_ns': ('t_ns', 'timestamp_ns', 'stamp_ns', 'nanoseconds'),
    'frame': ('frame_id', 'frame_number', 'frame_no', 'frame_index', 'frame_idx', 'image_id'),
}
"""Names of the columns that say when, each with others for the same."""
_NANOSECONDS = {'time': 10**9, 'time_ms': 10**6, 'time_us': 10**3, 'time_ns': 1}
_LATEST_NS = 2**63 - 1  # what 64 bits hold
_SEPARATORS = ('\t', ';', ',')


class TableError(ValueError):
    """A text file that cannot be used; names file, line and reason."""


def read_lines(path: str | Path) -> list[str]:
    """Return the lines of a text file; what cannot be read is a `TableError`."""
    check_size(path, TABLE, TableError)
    try:
        return Path(path).read_text(encoding='utf-8-sig').splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or str(error)
        raise TableError(f'{path} cannot be read: {reason}') from error


@dataclass(frozen=True, eq=False, slots=True)
class Table:
    """
    The rows of a file.

    Attributes
    ----------
    path : str or Path
        The file.
    line : (n,) int64 array
        Which line each row is.
    cells : dict of str to list of str
        Texts of each row, by the names of the columns; only of those that there are.
    unused : tuple of str
        Headings that stand for none of them.

    """

    path: str | Path
    line: NDArray[np.int64]
    cells: dict[str, list[str]]
    unused: tuple[str, ...]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.line)

    def error(self, row: int | np.integer[Any], reason: str) -> TableError:
        """Return an error about a row."""
        return TableError(f'{self.path}, line {self.line[row]}: {reason}')

    def texts(self, name: str) -> list[str]:
        """Return the texts of a column, empty ones where there is none."""
        return self.cells.get(name, [''] * len(self))

    def numbers(self, name: str) -> Floats:
        """
        Return a column, (n,); NaN where a cell is empty, or there is no such column.

        Raises
        ------
        TableError
            If a cell is no finite number.

        """
        values = np.full(len(self), np.nan)
        for row, text in enumerate(self.texts(name)):
            if text:
                try:
                    values[row] = float(text)
                except ValueError:
                    raise self.error(row, f'{name} is {text!r}, expected a number') from None
                if not math.isfinite(values[row]):
                    raise self.error(row, f'{name} is {text}, expected a finite number')
        return values

    def whole_numbers(self, name: str, least: int) -> NDArray[np.int64]:
        """Return a column, (n,), of which every cell is a whole number from one on."""
        values = self.numbers(name)
        for row in np.flatnonzero(~((values % 1 == 0) & (values >= least) & (values < 2**32))):
            text = self.texts(name)[row]
            hint = ' (--first-frame 0?)' if name == 'frame' and values[row] == 0 else ''
            raise self.error(
                row, f'{name} is {text or "empty"}, expected a whole number from {least}{hint}'
            )
        return values.astype(np.int64)

    def stamps_ns(self) -> NDArray[np.int64] | None:
        """
        Return when each row is, (n,) ns, exactly as written; None: the file has no times.

        Raises
        ------
        TableError
            If a cell is no time, or there are two columns of times.

        """
        names = [name for name in _NANOSECONDS if name in self.cells]
        if len(names) > 1:
            raise TableError(f'{self.path}: both {names[0]} and {names[1]}: which counts?')
        if not names:
            return None
        stamps = np.empty(len(self), np.int64)
        for row, text in enumerate(self.cells[names[0]]):
            try:
                exact = Decimal(text) * _NANOSECONDS[names[0]]
                stamps[row] = int(exact.to_integral_value())
            except (InvalidOperation, ValueError, OverflowError):
                raise self.error(row, f'{names[0]} is {text!r}, expected a time') from None
            if not 0 <= exact <= _LATEST_NS:
                raise self.error(row, f'{names[0]} is {text}, expected 0 or more')
        return stamps


def read_table(path: str | Path, spellings: Spellings) -> Table:
    """
    Read a table whose first line names its columns, between commas, semicolons or tabs.

    Parameters
    ----------
    path : str or Path
        The file.
    spellings : mapping
        Names of the columns, each with others for the same. Small and capital letters are one, and
        so are blanks, hyphens, brackets and underscores: ``Score``, ``x [m]`` is ``x_m``.

    Raises
    ------
    TableError
        If the file cannot be read, is empty, names a column twice, or a line has another number
        of fields.

    """
    lines = read_lines(path)
    top = next((index for index, line in enumerate(lines) if line.strip()), None)
    if top is None:
        raise TableError(f'{path} is empty')
    separator = next((each for each in _SEPARATORS if each in lines[top]), ',')
    rows = list(csv.reader(lines[top:], delimiter=separator, skipinitialspace=True))
    known = {one: name for name, more in spellings.items() for one in (name, *more)}
    headings = [_plain(text) for text in rows[0]]
    names = [known.get(heading, '') for heading in headings]
    for name in names:
        if name and names.count(name) > 1:
            both = [text for text, one in zip(rows[0], names) if one == name]
            raise TableError(f'{path}: the columns {" and ".join(both)} stand for the same')
    filled = [
        (line, row) for line, row in enumerate(rows[1:], top + 2) if any(map(str.strip, row))
    ]
    for line, row in filled:
        if len(row) != len(names):
            raise TableError(
                f'{path}, line {line}: {len(row)} fields, expected {len(names)} as in the header'
            )
    return Table(
        path,
        np.array([line for line, _ in filled], np.int64),
        {
            name: [row[column].strip() for _, row in filled]
            for column, name in enumerate(names)
            if name
        },
        tuple(text.strip() for text, name in zip(rows[0], names) if text.strip() and not name),
    )


def has_header(lines: list[str]) -> bool:
    """Tell whether the first line that is not empty names columns: it begins with no number."""
    first = next((line for line in lines if line.strip()), '0')
    return not _is_number(re.split(r'[,;\s]', first.strip())[0])


def _plain(heading: str) -> str:
    return re.sub(r'[^a-z0-9]+', '_', heading.strip().lower()).strip('_')


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
