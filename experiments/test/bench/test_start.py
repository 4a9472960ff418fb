import mctrack_experiments.bench.start as start


def test_a_start_that_finds_its_cache_is_faster(monkeypatch):
    loop = 'from mctrack_ros.tracking.kalman import predict; import numpy as np; '
    loop += 'predict(np.zeros((1, 4)), np.eye(4)[None], 1, 1)'
    monkeypatch.setattr(start, 'PREPARE', ('-c', loop))
    figures = start.bench_start().figures
    assert 0.0 < figures['help.s'] < figures['later.s'] + figures['first.s']
    assert figures['later.s'] < figures['first.s']
