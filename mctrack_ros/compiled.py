"""
Loops that are compiled: entry points with stated types, kept compiled between runs.

An entry point is compiled when it is first called, or ahead of that by `prepare`; the first time
after what it consists of has changed. Afterwards it is read from the user's cache.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import pickle
import sys
import tempfile
import types as types_of_python
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy
from numba import config, njit, types
from numba.core import codegen
from numba.core.caching import CacheImpl
from numba.core.environment import lookup_environment
from numba.core.registry import CPUDispatcher

_PACKAGE = __name__.partition('.')[0]
F = TypeVar('F', bound=Callable[..., Any])
_numba: Any = codegen  # which is typed in part
_LEAN: Any = {'no_cfunc_wrapper': True, 'error_model': 'numpy'}
"""Left out is what nobody needs: functions for C, checks for divisions by zero (infinite here)."""
_WRAPPER = '_ZN7cpython'
"""Names of functions that Python calls begin so."""
_OPTIONS: Any = {'nopython': True, 'boundscheck': None, **_LEAN}

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
COLUMN_2D = types.Array(types.f8, 2, 'A', readonly=True)
COLUMN_3D = types.Array(types.f8, 3, 'A', readonly=True)
COLUMN_SINGLES_2D = types.Array(types.f4, 2, 'A', readonly=True)
COLUMN_SINGLES_3D = types.Array(types.f4, 3, 'A', readonly=True)
COLUMN_IDS = types.Array(types.u4, 1, 'A', readonly=True)
COLUMN_BYTES = types.Array(types.u1, 1, 'A', readonly=True)
COLUMN_FLAGS = types.Array(types.b1, 1, 'A', readonly=True)
"""Types of columns of a table of records."""


class _EntryPoint(CPUDispatcher):
    """A function with one signature, which is compiled when it is first called."""

    declared: list[_EntryPoint] = []  # noqa: RUF012
    _can_compile: bool
    _cache: Any

    def __init__(self, function: Callable[..., Any], signature: Any) -> None:
        super().__init__(function, targetoptions=_OPTIONS)
        self._signature = signature
        self.declared.append(self)

    def prepare(self, wait: bool = True) -> bool:
        """Compile it or read it from the cache; False: another process does, and `wait` is not."""
        if self._can_compile:
            self.enable_caching()
            with _claimed(self._cache._impl.locator, wait) as is_claimed:
                if not is_claimed:
                    return False
                self.compile(self._signature)
            self.disable_compile()
        return True

    def _compile_for_args(self, *args: Any, **kws: Any) -> _EntryPoint:
        """Return what is called then: itself, which refuses arguments of other types."""
        self.prepare()
        return self

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Let a function that is being compiled call it."""
        self.prepare()
        return super().get_call_template(args, kws)


@contextmanager
def _claimed(locator: Any, wait: bool) -> Iterator[bool]:
    """Hold what only one process is to compile; False: another one has it, and `wait` is not."""
    if not isinstance(locator, _ByContent):
        yield True
        return
    file, own = locator.lock_file(), (1, int(locator.get_source_stamp()[:12], 16))
    try:
        fcntl.lockf(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB), *own)
    except OSError as error:  # file systems without locks let all compile
        yield not isinstance(error, BlockingIOError | PermissionError)
        return
    try:
        yield True
    finally:
        fcntl.lockf(file, fcntl.LOCK_UN, *own)


def compiled(signature: Any) -> Callable[[F], F]:
    """Compile a function that others call, for a numba signature."""

    def decorate(function: Any) -> Any:
        return (
            function if getattr(config, 'DISABLE_JIT', False) else _EntryPoint(function, signature)
        )

    return decorate


def prepare(package: str, *but: str) -> None:
    """
    Compile all entry points of a package that are imported, so that no image waits for them.

    Processes that do so at the same time share the work.

    Parameters
    ----------
    package : str
        Its name: ``mctrack_ros.perception``.
    *but : str
        Names of packages and modules in it that are left out: methods that are seldom chosen.

    """

    def lies_in(entry: _EntryPoint, *names: str) -> bool:
        return f'{entry.py_func.__module__}.'.startswith(tuple(f'{name}.' for name in names))

    wanted = [e for e in _EntryPoint.declared if lies_in(e, package) and not lies_in(e, *but)]
    for entry in [entry for entry in wanted if not entry.prepare(wait=False)]:
        entry.prepare()


class _Inner(CPUDispatcher):
    """A function that compiled functions call; called by Python, it is what Python makes of it."""

    py_func: Callable[..., Any]

    def add_overload(self, result: Any) -> None:
        """Keep what it is compiled to, which Python cannot call."""
        self.overloads[tuple(result.signature.args)] = result

    def _compile_for_args(self, *args: Any, **kws: Any) -> Callable[..., Any]:
        return self.py_func


def inner(function: F) -> F:
    """Compile a function that compiled functions call."""
    if getattr(config, 'DISABLE_JIT', False):
        return function
    options = {**_OPTIONS, 'no_cpython_wrapper': True}
    compiled_function: Any = _Inner(function, targetoptions=options)
    return cast(F, compiled_function)


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
    _lock_files: dict[Path, Any] = {}  # noqa: RUF012

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
                f'{_PACKAGE}: compiling inner loops, once: half a minute on two cores; '
                f'they are kept in {self._folder}',
                file=sys.stderr,
                flush=True,
            )
        return self

    def ensure_cache_path(self) -> None:
        """Create the folder; OSError: it cannot be written."""
        self._folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=self._folder).close()

    def lock_file(self) -> Any:
        """Return the file that processes lock a byte of; open from now on: to close it unlocks."""
        if self._folder not in self._lock_files:
            self._lock_files[self._folder] = open(self._folder / 'lock', 'w')  # noqa: SIM115
        return self._lock_files[self._folder]

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


class _Library(_numba.JITCodeLibrary):
    """
    What numba compiles a function to: machine code is made of what Python calls alone.

    Numba makes it of all that this calls, too, though the code of the caller holds that anyway.
    """

    _is_made = False

    def _is_called(self) -> bool:
        return any(each.name.startswith(_WRAPPER) for each in self.get_defined_functions())

    def _optimize_final_module(self) -> None:
        if self._is_called():
            super()._optimize_final_module()

    def _finalize_final_module(self) -> None:
        if self._shared_module is not None or self._is_called():
            self._make()
        else:
            self._finalized = True

    def _make(self) -> None:
        self._is_made = True
        super()._finalize_final_module()
        for variable in self._final_module.global_variables:
            environment = lookup_environment(variable.name)
            if environment is not None:
                self._codegen.set_env(variable.name, environment)

    def get_pointer_to_function(self, name: str) -> int:
        """Make machine code of what is asked for."""
        self._ensure_finalized()
        if not self._is_made and any(each.name == name for each in self.get_defined_functions()):
            self._make()
        return int(super().get_pointer_to_function(name))


def _set_env(codegen: Any, name: str, environment: Any) -> None:
    """Tell machine code the globals of its function, if there is any."""
    if codegen._engine.is_symbol_defined(name):
        _SET_ENV(codegen, name, environment)


_SET_ENV = _numba.JITCPUCodegen.set_env
_numba.JITCPUCodegen.set_env = _set_env
_numba.JITCPUCodegen._library_class = _Library
