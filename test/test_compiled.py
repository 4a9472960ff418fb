"""Compiled code is kept by what it consists of."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[1] / 'mctrack_ros' / 'compiled.py'
KERNELS = """
from numba import types

from mctrack_ros.compiled import compiled, inner

SCALE = 2.0


@inner
def grown(value):
    return value + 1.0


@compiled(types.f8(types.f8))
def scaled(value):
    return SCALE * grown(value)
"""


@pytest.fixture
def scaled_of_3(tmp_path):
    """Return a function that puts a package somewhere and asks its kernel, in a process."""

    def ask(text, where='here', module='kernels', ask='scaled(3.0)'):
        package = tmp_path / where / 'mctrack_ros'
        package.mkdir(parents=True, exist_ok=True)
        (package / '__init__.py').touch()
        shutil.copy(SOURCE, package)
        file = package.joinpath(*module.split('.')).with_suffix('.py')
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
        code = f'from mctrack_ros.{module} import scaled; print({ask})'
        done = subprocess.run(
            [sys.executable, '-c', code],
            env=os.environ
            | {
                'PYTHONPATH': str(package.parent),
                'XDG_CACHE_HOME': str(tmp_path / 'cache'),
                'PYTHONDONTWRITEBYTECODE': '1',  # a change within a second would not be seen
            },
            cwd=package.parent,
            capture_output=True,
            text=True,
            check=False,
        )
        assert not done.returncode, done.stderr
        return float(done.stdout), 'compiling inner loops' in done.stderr

    return ask


def test_nothing_is_compiled_twice_and_all_that_changed_is(scaled_of_3):
    assert scaled_of_3(KERNELS) == (8.0, True)
    assert scaled_of_3('# A comment\n' + KERNELS, 'elsewhere') == (8.0, False)
    assert scaled_of_3(KERNELS.replace('SCALE = 2.0', 'SCALE = 5.0')) == (20.0, True)
    assert scaled_of_3(KERNELS.replace('+ 1.0', '+ 2.0')) == (10.0, True)
    assert scaled_of_3(KERNELS) == (8.0, False)
    assert scaled_of_3(KERNELS, module='folder.kernels') == (8.0, True)  # its module moved


def test_nothing_is_compiled_before_it_is_called(scaled_of_3):
    assert scaled_of_3(KERNELS, ask='0.0') == (0.0, False)


FAILING = """
import numpy as np

from mctrack_ros.compiled import INTS_1D, compiled, inner, prepare
from numba import types


@inner
def checked(values):
    if values[0] < 0:
        raise ValueError('negative', values[0])
    return np.sort(values).sum()


@compiled(types.i8(INTS_1D))
def total(values):
    return checked(values) + len(np.zeros(3).reshape(3, 1))


def scaled(value):
    if value:
        prepare('mctrack_ros')
    assert total(np.array([3, 2])) == total(values=np.array([3, 2])) == 8
    for wrong in (np.array([-1]), np.array([1.5])):
        try:
            total(wrong)
        except (ValueError, TypeError) as error:
            value += len(error.args)
    assert list(checked(np.array([2, 1]))[None]) == [3]
    return value
"""


def test_what_loops_call_works_in_them_errors_too_freshly_compiled_and_from_the_cache(scaled_of_3):
    assert scaled_of_3(FAILING, ask='scaled(0.0)') == (3.0, True)
    assert scaled_of_3(FAILING) == (6.0, False)


SHARED = """
import os
import sys
import time

from mctrack_ros import compiled
from numba import types

compile = compiled._EntryPoint.compile


def slow(entry, signature):
    is_cached = entry._cache.load_overload(signature, entry.targetctx) is not None
    if not is_cached:
        with open(os.environ['XDG_CACHE_HOME'] + '/log', 'a') as file:
            file.write(entry.py_func.__name__)
        time.sleep(1.0)
    return compile(entry, signature)


compiled._EntryPoint.compile = slow


@compiled.compiled(types.f8(types.f8))
def a(value):
    return value


@compiled.compiled(types.f8(types.f8))
def b(value):
    return value + 1.0


def scaled(value):
    child = os.fork()
    compiled.prepare('mctrack_ros')
    if not child:
        os._exit(0)
    os.waitpid(child, 0)
    return a(value) + b(value)
"""


def test_processes_share_the_work(scaled_of_3, tmp_path):
    assert scaled_of_3(SHARED)[0] == 7.0
    assert sorted((tmp_path / 'cache/log').read_text()) == ['a', 'b']
