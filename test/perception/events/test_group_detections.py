import numpy as np

from mctrack_ros.interfaces import Detections
from mctrack_ros.perception.events.group_detections import merged_detections
from mctrack_ros.perception.feedback.persons_in_view import PersonsInView

STAMP_NS = 10**18


def in_view(*people):
    """People are (local id, global id, x on the ground); boxes lie side by side."""
    local_id = np.array([one[0] for one in people], np.int64)
    track_id = np.array([one[1] for one in people], np.int64)
    place = np.array([(one[2], 0.0) for one in people])
    box = np.array([(10.0 * row, 0, 10, 30) for row in range(len(people))])
    key = np.where(track_id > 0, track_id, -local_id)
    return PersonsInView(key, local_id, track_id, place, box, np.zeros(len(people), bool))


def rows(people, part, shown=(1,)):
    return merged_detections(
        in_view(*people), np.array(part), Detections.build(STAMP_NS, local_id=shown)
    )


def test_a_group_with_a_hidden_member_is_one_detection_of_all():
    merged = rows([(1, 7, 0.0), (0, 8, 1.0), (2, 9, 2.0)], [3, 3, 3], shown=(1, 2))
    assert merged.member_count.tolist() == [3]
    assert merged.members[0, :4].tolist() == [7, 8, 9, 0]
    assert merged.box[0].tolist() == [0, 0, 30, 30]
    assert merged.position[0].tolist() == [1, 0, 0]


def test_a_member_without_a_global_id_is_counted_and_not_named():
    merged = rows([(1, 0, 0.0), (0, 8, 1.0)], [3, 3])
    assert (merged.member_count.tolist(), merged.members[0, 0]) == ([2], 8)


def test_a_group_in_which_all_are_shown_needs_none():
    assert len(rows([(1, 7, 0.0), (2, 8, 1.0)], [3, 3], shown=(1, 2))) == 0


def test_one_who_is_hidden_by_nobody_is_not_told():
    assert len(rows([(1, 7, 0.0), (0, 8, 1.0), (0, 9, 5.0)], [3, 4, -1])) == 0
