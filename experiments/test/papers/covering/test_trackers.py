import numpy as np
import pytest

from mctrack_experiments.papers.covering.trackers import NAMES, run
from mctrack_ros.evaluation import evaluate_ground

CAMERAS = ('one', 'two')


@pytest.mark.parametrize('name', NAMES)
def test_every_tracker_follows_people_who_are_far_apart(walkers, name):
    tracks = walkers.scored(run(name, walkers, CAMERAS), CAMERAS)
    scores = evaluate_ground(walkers.truth(CAMERAS), tracks, walkers.gate_m)
    assert scores.mota > 0.95
    assert scores.switches == 0
    assert scores.mean_distance < 0.2


def test_the_particle_filter_draws_the_same_again(walkers):
    first, again = (run('pf_js', walkers, CAMERAS) for _ in range(2))
    np.testing.assert_array_equal(first.position, again.position)
