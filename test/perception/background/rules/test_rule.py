import numpy as np

from mctrack_ros.perception.background.rules.rule import BackgroundUpdate


def test_only_what_lies_in_the_image_of_a_tracked_box_is_tracked():
    mask = np.full((20, 30), 255, np.uint8)
    boxes = np.array([[-10, -4, 14, 10], [25, 15, 40, 40], [-9, 3, 5, 5]])
    lesson = BackgroundUpdate(np.zeros((20, 30, 3), np.uint8), mask, boxes, 0.0, 0)
    expected = np.zeros((20, 30), np.uint8)
    expected[:6, :4] = 255
    expected[15:, 25:] = 255
    assert np.array_equal(lesson.tracked_mask(), expected)
