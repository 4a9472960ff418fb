import pytest

from mctrack_ros.perception.config import FARTHEST_SHARE, DetectionLimits


def test_people_are_looked_for_down_to_a_share_of_their_usual_height(mapping):
    usual = mapping.usual_height_px(1.75)
    assert DetectionLimits(farthest_height_px=0.0).farthest_px(mapping) == pytest.approx(
        FARTHEST_SHARE * usual
    )
    nearest, most_distant = mapping.height_px([[0.0, -6.0], [0.0, 12.0]], 1.75)
    assert most_distant < usual < nearest


def test_a_stated_smallest_height_counts(mapping):
    assert DetectionLimits(farthest_height_px=11.0).farthest_px(mapping) == 11.0
