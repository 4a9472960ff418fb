"""Where the evaluator's real data are."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope='session')
def data_root():
    default = Path(__file__).resolve().parents[2].parent / 'shared' / 'data'
    folder = Path(os.environ.get('MCTRACK_DATA', default))
    if not folder.is_dir():
        pytest.skip('real data left out: no ../shared/data, and MCTRACK_DATA is not set')
    return folder
