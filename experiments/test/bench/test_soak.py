"""Three minutes of the soak: the processes' memory stays as it is."""

import os

import numpy as np
import pytest

from mctrack_experiments.bench.nodes.soak import Watched, bench_soak


def test_growth_and_latency_are_of_the_rest_beside_the_first_minutes():
    watched = Watched()
    for time_s in np.arange(0.0, 100.0, 5.0):
        watched.memory['steady'].append((time_s, 200.0 + 50.0 * (time_s < 20.0)))
        watched.memory['leaking'].append((time_s, 100.0 + 0.1 * time_s))
    for time_s in np.arange(0.0, 100.0, 0.1):
        watched.latencies.append((time_s, 10.0 if time_s < 20.0 else 15.0))
    figures = watched.figures(100.0, 20.0)
    assert figures['memory.steady.growth'] == pytest.approx(0.0)
    assert figures['memory.growth'] == pytest.approx(8.0 / 105.75, rel=0.01)
    assert figures['latency.p99_ratio'] == pytest.approx(1.5)


@pytest.mark.live
@pytest.mark.timeout(900)
def test_memory_does_not_grow_in_three_minutes(monkeypatch):
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    figures = bench_soak(3, domain=100 + os.getpid() % 100).figures
    assert figures['ids'] > 10
    assert figures['memory.growth'] < 0.03, figures
