"""What all tests share."""

import os
import sys
from pathlib import Path

import pytest
from hypothesis import settings

# What processes of tests compile is kept: they import the same again and again.
sys.dont_write_bytecode = False
os.environ.pop('PYTHONDONTWRITEBYTECODE', None)

# No test is timed: the first call of a loop compiles it, and machines are busy.
settings.register_profile('untimed', deadline=None)
settings.load_profile('untimed')

ROOT = Path(__file__).resolve().parent
DATA_REQUIRED = bool(os.environ.get('MCTRACK_REQUIRE_DATA'))

real_data_passed = 0


def real_data_folder():
    """Return where the real data are, or None."""
    named = os.environ.get('MCTRACK_DATA')
    folder = Path(named) if named else ROOT.parent / 'shared' / 'data'
    return folder if folder.is_dir() else None


@pytest.fixture(scope='session')
def data_root():
    """Return the folder of the real data, or leave the test out where it is absent."""
    folder = real_data_folder()
    if folder is None:
        if DATA_REQUIRED:
            pytest.fail('the real data are required, but MCTRACK_DATA names no folder')
        pytest.skip('real data left out: no ../shared/data, and MCTRACK_DATA is not set')
    return folder


def pytest_runtest_logreport(report):
    """Count the tests on real data that passed, over all worker processes."""
    global real_data_passed
    if report.when == 'call' and report.passed and 'real_data' in report.keywords:
        real_data_passed += 1


def pytest_sessionfinish(session):
    """Fail a run that had to test on the real data and did not."""
    is_worker = hasattr(session.config, 'workerinput')
    if DATA_REQUIRED and not is_worker and not real_data_passed and session.exitstatus == 0:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
        print('\nMCTRACK_REQUIRE_DATA is set, but no test on real data passed')


@pytest.fixture
def rendering_here(monkeypatch):
    """Let `simulate` render in this process."""
    from here import RenderingHere

    monkeypatch.setattr('mctrack_ros.simulation.recording.ProcessPoolExecutor', RenderingHere)
