import numpy as np
import pytest

from mctrack_ros.interfaces import Detections, EventCode, Events
from mctrack_ros.perception.overlay import GROUP, PREDICTED, Overlay

SECOND = 1_000_000_000
BLANK = np.zeros((100, 120, 3), np.uint8)


def one_person(stamp_ns=SECOND, **columns):
    return Detections.build(stamp_ns, box=[[10, 20, 20, 40]], local_id=[5], **columns)


def nothing(stamp_ns=SECOND):
    return Events.build(stamp_ns)


def test_a_box_has_the_colour_of_its_global_track_on_a_copy():
    drawn = [Overlay().draw(BLANK, one_person(track_id=[t]), nothing()) for t in (0, 3, 4)]
    assert not BLANK.any()
    colours = {tuple(each[40, 10].tolist()) for each in drawn}
    assert len(colours) == 3
    assert (0, 0, 0) not in colours
    assert not drawn[0][30:55, 15:25].any()


def test_predictions_are_drawn_where_they_are_finite():
    predicted = np.array([[10.0, 70.0, 20.0, 20.0], [np.nan] * 4])
    drawn = Overlay().draw(BLANK, Detections.build(SECOND), nothing(), predicted=predicted)
    assert tuple(drawn[80, 10]) == PREDICTED


@pytest.mark.parametrize('reported', ['by the tracker', 'by the detection'])
def test_a_group_has_a_frame(reported):
    members = {} if reported == 'by the tracker' else {'member_count': [2]}
    groups = [(5, 6)] if reported == 'by the tracker' else []
    drawn = Overlay().draw(BLANK, one_person(**members), nothing(), groups)
    assert tuple(drawn[60, 6]) == GROUP


def test_what_happened_stays_for_a_while():
    overlay = Overlay(memory_s=0.5)
    merge = Events.build(SECOND, event=[EventCode.MERGE], local_id=[5], others=[[6] + [0] * 15])
    lines = [
        overlay.draw(BLANK, Detections.build(stamp), events)[:20].any()
        for stamp, events in (
            (SECOND, merge),
            (SECOND + SECOND // 4, nothing()),
            (SECOND + SECOND, nothing()),
        )
    ]
    assert lines == [True, True, False]


def test_nothing_seen_leaves_the_image_as_it_is():
    image = np.random.default_rng(0).integers(0, 256, (20, 30, 3), np.uint8)
    assert np.array_equal(Overlay().draw(image, Detections.build(1), nothing(1)), image)
