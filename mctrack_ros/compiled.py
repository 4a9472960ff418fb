"""
Loops that are compiled: entry points with stated types, kept compiled between runs.

They are compiled when first imported after the sources have changed, which takes some seconds,
and read from the user's cache afterwards.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
import numpy
from numba import config, njit, types

F = TypeVar('F', bound=Callable[..., Any])

BYTES_2D = types.Array(types.u1, 2, 'C', readonly=True)
BYTES_3D = types.Array(types.u1, 3, 'C', readonly=True)
BOOLS_1D = types.Array(types.b1, 1, 'C', readonly=True)
BOOLS_2D = types.Array(types.b1, 2, 'C', readonly=True)
INTS_1D = types.Array(types.i8, 1, 'C', readonly=True)
INTS_2D = types.Array(types.i8, 2, 'C', readonly=True)
FLOATS_1D = types.Array(types.f8, 1, 'C', readonly=True)
FLOATS_2D = types.Array(types.f8, 2, 'C', readonly=True)
FLOATS_3D = types.Array(types.f8, 3, 'C', readonly=True)
"""Types of arguments; read-only, as the arrays of messages are."""
COLUMN_1D = types.Array(types.f8, 1, 'A', readonly=True)
COLUMN_2D = types.Array(types.f8, 2, 'A', readonly=True)
COLUMN_3D = types.Array(types.f8, 3, 'A', readonly=True)
COLUMN_SINGLES_2D = types.Array(types.f4, 2, 'A', readonly=True)
COLUMN_SINGLES_3D = types.Array(types.f4, 3, 'A', readonly=True)
COLUMN_IDS = types.Array(types.u4, 1, 'A', readonly=True)
COLUMN_STAMPS = types.Array(types.i8, 1, 'A', readonly=True)
COLUMN_BYTES = types.Array(types.u1, 1, 'A', readonly=True)
COLUMN_FLAGS = types.Array(types.b1, 1, 'A', readonly=True)
"""Types of columns of a table of records."""


def compiled(signature: Any) -> Callable[[F], F]:
    """Compile a function that others call, for a numba signature."""
    decorated: Callable[[F], F] = njit(signature, cache=True)
    return decorated


def inner(function: F) -> F:
    """Compile a function that compiled functions call."""
    decorated: F = njit(function)  # type: ignore[assignment]
    return decorated


def inlined(function: F) -> F:
    """Compile a short function into its callers: to hand it arrays costs more than it does."""
    decorated: F = njit(function, inline='always')  # type: ignore[assignment]
    return decorated


def _cache_folder() -> str:
    """Return a folder for these very sources and libraries; numba looks at one file only."""
    digest = hashlib.sha256(f'numba {numba.__version__}, numpy {numpy.__version__}'.encode())
    for path in sorted(Path(__file__).parent.rglob('*.py')):
        source = path.read_bytes()
        if b'mctrack_ros.compiled' in source:
            digest.update(source)
    base = getattr(config, 'CACHE_DIR', '') or os.environ.get('XDG_CACHE_HOME')
    base = base or os.path.expanduser('~/.cache')
    return os.path.join(base, 'mctrack_ros', digest.hexdigest()[:16])


config.CACHE_DIR = _cache_folder()  # type: ignore[attr-defined]
