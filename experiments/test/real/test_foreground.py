import cv2
import numpy as np
import pytest

from mctrack_experiments.real.foreground.comparison import ours
from mctrack_experiments.real.foreground.peers import filtered, peers
from mctrack_experiments.real.foreground.sequences import SEQUENCES, measure


@pytest.fixture
def data(tmp_path):
    """Sequences in which a square moves; a part of each truth is not scored."""
    for sequence in SEQUENCES:
        for kind in ('input', 'groundtruth'):
            (tmp_path / 'foreground' / sequence / kind).mkdir(parents=True)
        for number in range(540, 600):
            image, truth = np.full((48, 64, 3), 90, np.uint8), np.zeros((48, 64), np.uint8)
            if number >= 575:
                left = 2 * (number - 575)
                image[20:30, left : left + 10] = (30, 40, 200)
                truth[20:30, left : left + 10] = 255
            truth[:5] = 85
            folder = tmp_path / 'foreground' / sequence
            cv2.imwrite(str(folder / 'input' / f'in{number:06d}.png'), image)
            cv2.imwrite(str(folder / 'groundtruth' / f'gt{number:06d}.png'), truth)
    return tmp_path


def test_what_is_right_scores_one_and_what_finds_nothing_zero(data):
    def right(image, _):
        return np.where(image[..., 2] > 150, np.uint8(255), np.uint8(0))

    assert measure(data, lambda: right)['office.f'] == 1.0
    assert measure(data, lambda: lambda image, _: None)['office.f'] == 0.0


def test_our_model_finds_the_square(data):
    assert measure(data, ours)['highway.f'] > 0.9


def test_peers_of_opencv_are_run_with_their_shadows_left_out(data):
    assert {'mog2', 'knn'} <= peers().keys()
    figures = measure(data, filtered(peers()['knn'], 5))
    assert 0.0 <= figures['corridor.f'] <= 1.0


@pytest.mark.real_data
def test_real_foreground_reaches_its_targets(data_root):
    figures = measure(data_root, ours)
    assert figures['highway.f'] > 0.95
    assert figures['office.f'] > 0.95
    assert figures['corridor.f'] > 0.85
