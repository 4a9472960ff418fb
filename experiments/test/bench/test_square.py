import numpy as np

from mctrack_experiments.bench.perception.occupancy import _people, _square
from mctrack_experiments.bench.perception.square import (
    PEOPLE,
    SIDE_M,
    square_world,
    ticks_of,
    views_of,
)
from mctrack_ros.fusion.occupancy.config import OccupancyConfig


def test_people_cross_the_square_and_most_are_found_without_tracks():
    world = square_world(1, 2.0)
    place = world.motion.position
    assert place.shape == (20, PEOPLE, 2)
    assert ((place >= 0) & (place <= SIDE_M)).all()
    names = tuple(camera.name for camera in world.cameras)
    ticks = ticks_of(world)[-2:]
    assert [len(tick.messages) for tick in ticks] == [8, 8]
    found = list(_people(OccupancyConfig(), names, ticks, lambda: views_of(world.cameras)))
    for (mean, covariance), truth in zip(found, place[-2:]):
        gaps = np.linalg.norm(mean[:, None] - truth, axis=2)
        assert (gaps.min(axis=0) < 0.5).sum() >= 0.85 * PEOPLE
        assert (np.linalg.eigvalsh(covariance) > 0).all()


def test_the_bench_times_ticks_and_scores_tracks():
    figures = _square(4.0, 2)
    assert 0 < figures['square.p50_ms'] <= figures['square.p99_ms']
    assert figures['square.moda'] > 0.9
    assert 0 < figures['square.nees'] < 2
