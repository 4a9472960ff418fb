import numpy as np
import pytest
from matplotlib.image import imread

from mctrack_experiments.papers.event_tracking.fig20 import reproduce_fig20

pytestmark = pytest.mark.xdist_group('fig20')


@pytest.fixture(scope='module')
def drawn(tmp_path_factory):
    image = tmp_path_factory.mktemp('fig20') / 'paths.png'
    return reproduce_fig20(image, seed=1, duration_s=3.0), image


def test_two_players_are_followed(drawn):
    figures = drawn[0].figures
    assert len({name.split('.')[0] for name in figures}) == 2
    errors = [value for name, value in figures.items() if 'rmse' in name]
    assert 0 < max(errors) < 1.0


def test_their_paths_are_drawn(drawn):
    image = imread(drawn[1])[..., :3]
    coloured = np.ptp(image, axis=2) > 0.3
    assert coloured[: len(image) // 2].any()
    assert coloured[len(image) // 2 :].any()
