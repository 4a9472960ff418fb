import numpy as np
import pytest
from matplotlib.image import imread

from mctrack_experiments.papers.event_tracking.fig20 import reproduce_fig20

pytestmark = pytest.mark.xdist_group('match')


def test_two_players_are_followed_and_drawn(kept_matches, tmp_path):
    figures = reproduce_fig20(tmp_path / 'paths.png', seed=1, duration_s=3.0).figures
    assert len({name.split('.')[0] for name in figures}) == 2
    errors = [value for name, value in figures.items() if 'rmse' in name]
    assert 0 < max(errors) < 1.0
    image = imread(tmp_path / 'paths.png')[..., :3]
    coloured = np.ptp(image, axis=2) > 0.3
    assert coloured[: len(image) // 2].any()
    assert coloured[len(image) // 2 :].any()
