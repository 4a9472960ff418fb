import numpy as np
import pytest

from mctrack_experiments.datasets import kloppy_motion
from mctrack_experiments.datasets.kloppy_motion import MISSING, Sample, has_kloppy, real_world
from mctrack_ros.simulation import PTZ, PtzScenario, Scenario

needs_kloppy = pytest.mark.skipif(not has_kloppy(), reason=MISSING)


@needs_kloppy
@pytest.mark.filterwarnings('ignore')
@pytest.mark.parametrize('sample', Sample)
def test_real_players_drive_the_simulator(sample):
    world = real_world(PtzScenario(duration_s=20, follows_play=True), sample)
    active, velocity = world.active, world.motion.velocity
    assert active[:, :22].sum(axis=1).max() >= 7
    assert not active[:, 22:].any()
    speed = np.linalg.norm(velocity, axis=2)[active]
    assert speed.max() <= kloppy_motion.FASTEST_MPS
    assert 1 < speed.mean() < 5
    image, _ = PTZ.renderer(world, 0).frame(50)
    assert image.shape == (576, 768, 3)


@needs_kloppy
@pytest.mark.filterwarnings('ignore')
def test_a_sample_that_is_too_short_is_refused():
    with pytest.raises(ValueError, match='ends after'):
        real_world(Scenario(duration_s=120), Sample.HAWKEYE)


def test_gaps_are_absences_and_samples_are_joined():
    path = np.array([(0.0, 0, 0), (0.1, 1, 0), (5.0, 50, 0), (5.1, 51, 0)])
    places, there = kloppy_motion._read_off(path, np.array([0.05, 2.5, 5.05, 9.0]))
    np.testing.assert_allclose(places[[0, 2], 0], [0.5, 50.5])
    assert there.tolist() == [True, False, True, False]


@pytest.mark.skipif(has_kloppy(), reason='kloppy is installed')
def test_without_kloppy_it_says_how_to_install_it():
    with pytest.raises(ImportError, match='motion'):
        real_world(Scenario(), Sample.HAWKEYE)
