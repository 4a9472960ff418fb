"""A person who is followed by id."""

import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode, EventCode, Events, Tracks, TrackStatus
from mctrack_ros.ros.interop.followed import Followed

NOTHING = Events.build(0)


def tracks(track_id, velocity=(0.0, 1.0), status=TrackStatus.CONFIRMED):
    return Tracks.build(
        0, position=[[3.0, 4.0, 0.0]], velocity=[velocity], track_id=[track_id], status=[status]
    )


def test_a_pose_looks_where_the_person_goes_and_keeps_that_while_they_stand():
    followed = Followed(12)
    for velocity in ((0.0, 1.0), (0.1, 0.0)):
        pose = followed.pose(tracks(12, velocity), NOTHING, 'map')
        assert (pose.header.frame_id, pose.pose.position.x, pose.pose.position.y) == ('map', 3, 4)
        turn = pose.pose.orientation
        assert 2 * np.arctan2(turn.z, turn.w) == pytest.approx(np.pi / 2)


def test_a_corrected_id_is_followed_also_when_two_were_exchanged():
    followed = Followed(12)
    exchanged = Events.build(
        0, event=[EventCode.CORRECTION] * 2, old_id=[12, 5], new_id=[5, 12],
        position=[[0.0, 0.0, 0.0]] * 2,
    )  # fmt: skip
    assert followed.pose(tracks(12), exchanged, 'map') is None
    assert followed.track_id == 5
    assert followed.pose(tracks(5), NOTHING, 'map') is not None


def test_nobody_and_who_has_left_have_no_pose():
    assert Followed(0).pose(tracks(0), NOTHING, 'map') is None
    assert Followed(12).pose(tracks(12, status=TrackStatus.DELETED), NOTHING, 'map') is None
    assert Followed(12).pose(tracks(13), NOTHING, 'map') is None


def test_next_comes_the_confirmed_person_of_the_next_higher_id_and_after_the_last_the_first():
    status = [
        *(TrackStatus.CONFIRMED, TrackStatus.TENTATIVE, TrackStatus.COASTING),
        *(TrackStatus.DELETED, TrackStatus.GROUPED, TrackStatus.CONFIRMED),
    ]
    several = Tracks.build(
        0, position=np.zeros((6, 3)), track_id=range(3, 9), status=status,
        class_id=[ClassCode.PERSON] * 5 + [ClassCode.VEHICLE],
    )  # fmt: skip
    followed, seen = Followed(0), []
    assert followed.next_id() == 0
    followed.pose(several, NOTHING, 'map')
    for _ in range(4):
        followed.choose(followed.next_id())
        seen.append(followed.track_id)
    assert seen == [3, 5, 7, 3]
    followed.choose(4000)
    assert followed.next_id() == 3
