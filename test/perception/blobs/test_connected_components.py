import cv2
import numpy as np
import pytest

from mctrack_ros.perception.blobs.connected_components import component_boxes

SHAPES = [(40, 50), (37, 64), (1, 9), (7, 3), (120, 317)]


def masks(shape, seed=0):
    """Return sparse, dense and blotchy masks, an empty one and a full one."""
    rng = np.random.default_rng(seed)
    blotchy = cv2.blur(rng.random(shape), (5, 3)) < 0.5
    chosen = [rng.random(shape) < share for share in (0.02, 0.7, 0.95)]
    empty = np.zeros(shape, bool)
    return [255 * mask.astype(np.uint8) for mask in (*chosen, blotchy, empty, ~empty)]


@pytest.mark.parametrize('shape', SHAPES)
def test_components_are_those_of_opencv(shape):
    for mask in masks(shape):
        _, _, expected, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
        assert sorted(component_boxes(mask).tolist()) == sorted(expected[1:, :4].tolist())


def test_a_row_does_not_run_on_into_the_next():
    mask = np.zeros((4, 16), np.uint8)
    mask[1, 14:] = mask[2, :2] = 255
    assert component_boxes(mask).tolist() == [[14, 1, 2, 1], [0, 2, 2, 1]]
