import numpy as np
import pytest

from mctrack_ros.interfaces import EventCode
from mctrack_ros.perception.events.event_log import HIDDEN, SEEN, EventLog
from mctrack_ros.perception.feedback.persons_in_view import PersonsInView


def in_view(*local_ids):
    count = len(local_ids)
    return PersonsInView(
        np.arange(1, count + 1),
        np.array(local_ids),
        np.arange(11, 11 + count),
        np.zeros((count, 2)),
        np.zeros((count, 4)),
        np.zeros(count, bool),
    )


@pytest.mark.parametrize(
    ('local_ids', 'expected'),
    [((1, 2), SEEN**2), ((1, 0), SEEN * HIDDEN), ((3, 0, 4, 0), SEEN**2 * HIDDEN**2)],
)
def test_the_more_are_named_and_hidden_the_less_probable_is_an_event(local_ids, expected):
    log, everybody = EventLog(0), np.arange(len(local_ids))
    log.add_group(EventCode.MERGE, in_view(*local_ids), everybody[:1], everybody[1:])
    assert log.rows().probability[0] == pytest.approx(expected)


def test_who_is_named_alone_is_as_probable_with_a_track_or_without():
    log = EventLog(0)
    log.add_target(EventCode.ENTER, 7, np.zeros(3))
    log.add_group(EventCode.STABLE, in_view(5), np.array([0]), np.zeros(0, np.int64))
    assert log.rows().probability == pytest.approx([SEEN, SEEN])
