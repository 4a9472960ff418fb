import numpy as np
import pytest

from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception import FeedbackBuffer

PERIOD, DELAY = 40, 80


def feedback(stamp_ns, **columns):
    """Return feedback of targets that are somewhere, as surely as any."""
    known = np.tile(np.eye(4), (len(columns.get('track_id', ())), 1, 1))
    if len(known):
        columns = {'position': np.zeros((len(known), 3)), 'covariance': known} | columns
    return Feedback.build(stamp_ns, **columns)


def test_image_gets_the_feedback_of_the_tick_before_the_delay():
    buffer = FeedbackBuffer(PERIOD, DELAY)
    buffer.select(20)
    for stamp in (20, 60, 100):
        buffer.push(feedback(stamp))
    found, missed = buffer.select(140)
    assert found.stamp_ns == 60
    assert not missed


def test_newer_feedback_does_not_stand_in_for_the_wanted():
    buffer = FeedbackBuffer(PERIOD, DELAY)
    buffer.select(20)
    buffer.push(feedback(100))
    assert buffer.select(140) == (None, True)


def test_nothing_is_missed_before_the_first_feedback_can_exist():
    buffer = FeedbackBuffer(PERIOD, DELAY)
    assert [buffer.select(stamp) for stamp in (20, 60)] == [(None, False)] * 2
    assert buffer.select(100) == (None, True)


def test_order_of_arrival_does_not_matter():
    buffer = FeedbackBuffer(PERIOD, DELAY)
    buffer.select(20)
    for stamp in (100, 20, 60):
        buffer.push(feedback(stamp))
    assert buffer.select(100)[0].stamp_ns == 20


def test_last_feedback_of_a_tick_counts():
    buffer = FeedbackBuffer(PERIOD, DELAY)
    buffer.push(feedback(20))
    buffer.push(feedback(30))
    assert buffer.select(100)[0].stamp_ns == 30


@pytest.mark.parametrize(('period', 'delay'), [(0, 1), (-5, 1), (5, -1)])
def test_bad_times_are_refused(period, delay):
    with pytest.raises(ValueError, match='period_ns'):
        FeedbackBuffer(period, delay)


def test_corrections_are_told_once_to_a_fast_camera():
    buffer = FeedbackBuffer(PERIOD, DELAY)
    buffer.push(feedback(60, track_id=[2], previous_id=[7]))
    first, again = (buffer.select(stamp)[0] for stamp in (125, 145))
    assert first.corrections() == {7: 2}
    assert again.corrections() == {}
    assert again.track_id.tolist() == [2]


def correction(stamp_ns, changes):
    """Return feedback of targets 2, 3 and 4 in which ids changed, old to new."""
    previous = {new: old for old, new in changes.items()}
    before = [previous.get(track_id, 0) for track_id in (2, 3, 4)]
    return feedback(stamp_ns, track_id=[2, 3, 4], previous_id=before)


@pytest.mark.parametrize(
    ('changes', 'reported'),
    [
        ([{7: 2}, {}, {}], {7: 2}),
        ([{7: 2}, {2: 3}, {}], {7: 3}),
        ([{2: 3, 3: 2}, {}, {7: 4}], {2: 3, 3: 2, 7: 4}),
        ([{2: 3, 3: 2}, {2: 3, 3: 2}, {}], {}),
        ([{2: 3, 3: 2}, {2: 4, 4: 2}, {}], {2: 3, 3: 4, 4: 2}),
    ],
    ids=['skipped', 'twice', 'swap and another', 'swap and back', 'around'],
)
def test_a_slow_camera_is_told_what_changed_between_its_images(changes, reported):
    buffer = FeedbackBuffer(PERIOD, DELAY)
    for index, change in enumerate(changes):
        buffer.push(correction(20 + PERIOD * index, change))
    found, _ = buffer.select(20 + PERIOD * 2 + DELAY)
    assert found.corrections() == reported
    buffer.push(correction(20 + PERIOD * 3, {}))
    assert buffer.select(20 + PERIOD * 3 + DELAY)[0].corrections() == {}


def test_corrections_of_feedback_that_came_too_late_are_told_next_time():
    buffer = FeedbackBuffer(PERIOD, DELAY)
    buffer.push(correction(60, {}))
    assert buffer.select(60 + DELAY)[0].corrections() == {}
    buffer.push(correction(20, {7: 2}))
    buffer.push(correction(100, {}))
    assert buffer.select(100 + DELAY)[0].corrections() == {7: 2}


def test_rows_that_no_target_can_be_are_left_out():
    buffer = FeedbackBuffer(PERIOD, DELAY)
    position = [[1.0, 2.0, 0.0], [3e38, 0.0, 0.0], [5.0, 6.0, 0.0]]
    assert buffer.push(feedback(60, position=position, track_id=[1, 2, 3])) == 1
    found, _ = buffer.select(140)
    assert found.track_id.tolist() == [1, 3]
