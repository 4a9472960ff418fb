"""What a camera file states, by meaning: numbers, however they are written down."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.files.keyed.keys import sorted_keys, spelling_table

Floats = NDArray[np.float64]
LARGEST_WHOLE = 1_000_000
"""No image is so wide, no matrix so large."""


class Stated:
    """
    What a file states, by meaning.

    Parameters
    ----------
    values : mapping
        What the file holds: numbers, texts, lists, or mappings with `data`.
    where : str or Path
        What it is from, to name.
    spellings : mapping of str to tuple of str, optional
        What each meaning is called; unless given, as cameras of OpenCV's and ROS's have it.

    Raises
    ------
    CalibrationError
        If a key may say where things are seen and is not known.

    """

    def __init__(
        self,
        values: Mapping[Any, Any],
        where: str | Path,
        spellings: Mapping[str, tuple[str, ...]] | None = None,
    ) -> None:
        self._values, self.where = values, where
        self._keys = sorted_keys(values, where, spellings or spelling_table(values))

    def __contains__(self, meaning: str) -> bool:
        """Tell whether the file states a meaning."""
        return meaning in self._keys

    def key(self, meaning: str) -> str:
        """Return how the file spells a meaning; empty if it does not state it."""
        return str(self._keys.get(meaning, [''])[0])

    def each(self, meaning: str) -> list[tuple[str, Any]]:
        """Return the keys of a meaning, and what they hold."""
        return [(str(key), self._values[key]) for key in self._keys.get(meaning, [])]

    def value(self, meaning: str) -> Any:
        """Return what the keys of a meaning hold, or None; they have to hold the same."""
        held = self.each(meaning)
        for key, value in held[1:]:
            if value != held[0][1]:
                raise self.error(f'{held[0][0]} and {key} differ: keep one')
        return held[0][1] if held else None

    def numbers(self, meaning: str, *counts: int) -> Floats:
        """Return the finite numbers that a meaning holds; so many as a count says, if any does."""
        value, key = self.value(meaning), self.key(meaning)
        try:
            numbers: Floats = np.asarray(_flat(value), np.float64)
        except (TypeError, ValueError, OverflowError) as error:
            raise self.error(f'{key} is no matrix, or holds more than numbers') from error
        expected = counts or self._shape(value) or (len(numbers),)
        if len(numbers) not in expected or not np.isfinite(numbers).all():
            raise self.error(
                f'{key} holds {len(numbers)} numbers, expected finite '
                f'{" or ".join(str(each) for each in expected)}'
            )
        return numbers

    def whole(self, meaning: str) -> int:
        """Return the whole number that a meaning holds; 0 if it is not stated."""
        return whole(self.value(meaning), f'{self.where}: {self.key(meaning)}')

    def error(self, reason: str) -> CalibrationError:
        """Return a refusal that names the file."""
        return CalibrationError(f'{self.where}: {reason}')

    def _shape(self, value: Any) -> tuple[int, ...]:
        """Return how many numbers a matrix says it holds, if it does."""
        if not isinstance(value, Mapping) or not {'rows', 'cols'} <= value.keys():
            return ()
        rows, columns = (whole(value[key], f'{self.where}: {key}') for key in ('rows', 'cols'))
        return (rows * columns,)


def whole(value: Any, what: str) -> int:
    """
    Return a whole number that is not negative; 0 for None.

    Raises
    ------
    CalibrationError
        If it is something else; names what it is of.

    """
    try:
        number = 0.0 if value is None else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not (0 <= number <= LARGEST_WHOLE and number.is_integer()):
        raise CalibrationError(
            f'{what} is {value!r}, expected a whole number up to {LARGEST_WHOLE}'
        )
    return int(number)


def _flat(value: Any) -> list[float]:
    """Return the numbers of a list, of rows, or of what a matrix has as `data`, one by one."""
    if isinstance(value, Mapping):
        value = value.get('data')
    if isinstance(value, list | tuple | np.ndarray):
        rows = [each if isinstance(each, list | tuple | np.ndarray) else [each] for each in value]
        return [float(each) for row in rows for each in row]
    if isinstance(value, str):
        raise TypeError(f'{value!r} is no list of numbers')
    return [float(value)]
