"""
Loops that are compiled: entry points with stated types, kept compiled between runs.

They are compiled when first imported after what they consist of has changed, and read from the
user's cache afterwards.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
import tempfile
import types as types_of_python
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
import numpy
from numba import config, njit, types
from numba.core.caching import CacheImpl

_PACKAGE = __name__.partition('.')[0]
F = TypeVar('F', bound=Callable[..., Any])
_LEAN: Any = {'no_cfunc_wrapper': True, 'error_model': 'numpy'}
"""Left out is what nobody needs: functions for C, checks for divisions by zero (infinite here)."""

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
    decorated: Callable[[F], F] = njit(signature, cache=True, **_LEAN)
    return decorated


def inner(function: F) -> F:
    """Compile a function that compiled functions call."""
    decorate: Callable[[F], F] = njit(**_LEAN)
    return decorate(function)


def inlined(function: F) -> F:
    """Compile a short function into its callers: to hand it arrays costs more than it does."""
    decorate: Callable[[F], F] = njit(inline='always', **_LEAN)
    return decorate(function)


class _ByContent:
    """
    Where numba keeps a function's compiled code: under a digest of all that it is compiled from.

    So it is compiled again when it, a function that it calls or a constant that it reads changes,
    or the name of their module, by which numba finds it; and neither when other lines of its file
    do nor when the package is installed elsewhere.
    """

    _is_announced = False

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        digest = hashlib.sha256(f'numba {numba.__version__}, numpy {numpy.__version__}'.encode())
        _add_function(digest, function, set())
        self._digest, self._folder = digest.hexdigest()[:24], folder

    @classmethod
    def from_function(cls, function: Callable[..., Any], _: str) -> _ByContent | None:
        """Return the place for a function of this package; None: it is another's, or no place."""
        if not function.__module__.startswith(f'{_PACKAGE}.'):
            return None
        base = getattr(config, 'CACHE_DIR', '') or os.environ.get('XDG_CACHE_HOME')
        self = cls(function, Path(base or os.path.expanduser('~/.cache')) / _PACKAGE)
        try:
            self.ensure_cache_path()
        except OSError:
            return None
        if not cls._is_announced and not any(self._folder.glob(f'*-{self._digest}.*.nbi')):
            cls._is_announced = True
            print(
                f'{_PACKAGE}: compiling inner loops, once: up to some minutes; '
                f'they are kept in {self._folder}',
                file=sys.stderr,
                flush=True,
            )
        return self

    def ensure_cache_path(self) -> None:
        """Create the folder; OSError: it cannot be written."""
        self._folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=self._folder).close()

    def get_cache_path(self) -> str:
        """Return the folder."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Return the key of this version of the function."""
        return self._digest

    get_disambiguator = get_source_stamp


def _add_function(digest: Any, function: Any, seen: set[Any]) -> None:
    """Add a function, all that it calls and the constants that it reads to a digest."""
    if function in seen:
        return
    seen.add(function)
    digest.update(f'{function.__module__} {function.__defaults__!r}'.encode())
    for cell in function.__closure__ or ():
        _add_value(digest, cell.cell_contents, seen)
    names = _add_code(digest, function.__code__)
    for name in sorted(names & function.__globals__.keys()):
        digest.update(name.encode())
        _add_value(digest, function.__globals__[name], seen)


def _add_code(digest: Any, code: types_of_python.CodeType) -> set[str]:
    """Add bytecode, that of inner functions too, and return the names that it looks up."""
    names = set(code.co_names)
    digest.update(code.co_code + repr((code.co_names, code.co_varnames)).encode())
    for constant in code.co_consts:
        if isinstance(constant, types_of_python.CodeType):
            names |= _add_code(digest, constant)
        else:
            digest.update(repr(constant).encode())
    return names


def _add_value(digest: Any, value: Any, seen: set[Any]) -> None:
    """Add what a name stands for: a compiled function by its content, a constant by its value."""
    if hasattr(value, 'py_func'):
        digest.update(repr(sorted(value.targetoptions.items())).encode())
        _add_function(digest, value.py_func, seen)
    elif isinstance(value, types_of_python.ModuleType):
        digest.update(value.__name__.encode())
    elif callable(value):
        digest.update(getattr(value, '__qualname__', repr(value)).encode())
    else:
        digest.update(pickle.dumps(value))


CacheImpl._locator_classes = [_ByContent, *CacheImpl._locator_classes]
