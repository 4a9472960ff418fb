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

    def ask(text, where='here', module='kernels'):
        package = tmp_path / where / 'mctrack_ros'
        package.mkdir(parents=True, exist_ok=True)
        (package / '__init__.py').touch()
        shutil.copy(SOURCE, package)
        file = package.joinpath(*module.split('.')).with_suffix('.py')
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
        code = f'from mctrack_ros.{module} import scaled; print(scaled(3.0))'
        done = subprocess.run(
            [sys.executable, '-c', code],
            env=os.environ
            | {'PYTHONPATH': str(package.parent), 'XDG_CACHE_HOME': str(tmp_path / 'cache')},
            cwd=package.parent,
            capture_output=True,
            text=True,
            check=True,
        )
        return float(done.stdout), 'compiling inner loops' in done.stderr

    return ask


def test_nothing_is_compiled_twice_and_all_that_changed_is(scaled_of_3):
    assert scaled_of_3(KERNELS) == (8.0, True)
    assert scaled_of_3('# A comment\n' + KERNELS, 'elsewhere') == (8.0, False)
    assert scaled_of_3(KERNELS.replace('SCALE = 2.0', 'SCALE = 5.0')) == (20.0, True)
    assert scaled_of_3(KERNELS.replace('+ 1.0', '+ 2.0')) == (10.0, True)
    assert scaled_of_3(KERNELS) == (8.0, False)
    assert scaled_of_3(KERNELS, module='folder.kernels') == (8.0, True)  # its module moved
