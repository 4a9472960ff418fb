import numpy as np

from mctrack_ros.interfaces import Detections
from mctrack_ros.perception.overlay import draw_overlay


def test_boxes_are_drawn_on_a_copy():
    image = np.zeros((100, 120, 3), np.uint8)
    detections = Detections.build(
        1,
        position=np.zeros((3, 3)),
        box=[[10, 20, 20, 40], [50, 20, 40, 40], [95, 20, 20, 40]],
        member_count=[1, 2, 1],
        score=[1.0, 1.0, 0.2],
    )
    drawn = draw_overlay(image, detections, np.array([[10.0, 70.0, 20.0, 20.0], [np.nan] * 4]))
    assert not image.any()
    colours = [
        tuple(drawn[row, column]) for row, column in ((40, 10), (40, 50), (40, 95), (80, 10))
    ]
    assert len(set(colours)) == 4
    assert (0, 0, 0) not in colours


def test_nothing_seen_leaves_the_picture_as_it_is():
    image = np.random.default_rng(0).integers(0, 256, (20, 30, 3), np.uint8)
    assert np.array_equal(draw_overlay(image, Detections.build(1), np.zeros((0, 4))), image)
