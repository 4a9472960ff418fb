"""The shared benchmark, where it is, and a few scenes of it."""

from pathlib import Path

import pytest

from mctrack_experiments.bench.fusion.toolkit import Toolkit

ROOT = Path(__file__).resolve().parents[4]


@pytest.fixture(scope='session')
def folder():
    """Return the benchmark's folder, or leave the test out where it is absent."""
    folder = ROOT.parent / 'shared' / 'bench'
    if not folder.is_dir():
        pytest.skip('fusion benchmark left out: no ../shared/bench')
    return folder


@pytest.fixture(scope='session')
def toolkit(folder):
    """Return the benchmark's modules."""
    return Toolkit(folder)


@pytest.fixture(scope='session')
def scene(toolkit):
    """Return two seconds of a base scene."""
    return toolkit.scene(50, 1)
