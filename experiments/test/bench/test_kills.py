"""Two kills of each: nothing is missing that should not be."""

import os

import pytest

from mctrack_experiments.bench.nodes.kills import bench_kills
from mctrack_experiments.postgres_server import missing

pytestmark = [pytest.mark.live, pytest.mark.timeout(900)]


def test_who_is_killed_loses_half_a_second_at_most(monkeypatch):
    if lacking := missing():
        pytest.skip(f'no PostgreSQL with PostGIS: {lacking}')
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    figures = bench_kills(2, seed=7, domain=100 + os.getpid() % 100).figures
    for name in ('store', 'database', 'fusion'):
        assert figures[f'{name}.faults'] == 0
        assert figures[f'{name}.missing_s'] <= 0.5
    assert figures['database.missing_s'] == figures['database.stored_twice'] == 0
    assert (figures['store.runs'], figures['database.runs'], figures['fusion.runs']) == (1, 1, 1)
