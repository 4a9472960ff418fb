import numpy as np
import pytest

from mctrack_ros.interfaces import EventCode, Feedback
from mctrack_ros.perception.events.appearance_events import (
    AppearanceEvents,
)
from mctrack_ros.perception.events.event_log import EventLog
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.table import FilterConfig, LocalTracks

START_NS, PERIOD_NS = 10**18, 40_000_000


class Camera:
    """Believed tracks with the ids that are given, and feedback of two periods ago."""

    def __init__(self, mapping):
        self.tracks = LocalTracks(FilterConfig(), mapping, SizeTable(mapping))
        extent = np.array([0.6, 1.75])
        self.presence = AppearanceEvents(extent, SizeTable(mapping), mapping)
        self.now_ns = START_NS

    def begin(self, track_id=0):
        box = np.array([[100.0, 100, 20, 50]])
        noise, colours = np.eye(2)[None], np.zeros((1, 48))
        row = self.tracks.start(np.zeros((1, 2)), box, noise, colours, self.now_ns)
        self.tracks.confirmed[row], self.tracks.track_id[row] = True, track_id

    def show(self, *targets, feedback=True, foreground=True):
        """Advance an image; targets are (id, x, y)."""
        self.now_ns += PERIOD_NS
        reported = None
        if feedback:
            position = np.array([[x, y, 0.0] for _, x, y in targets]).reshape(-1, 3)
            ids = [target for target, *_ in targets]
            reported = Feedback.build(self.now_ns - 2 * PERIOD_NS, position=position, track_id=ids)
        log = EventLog(self.now_ns)
        blobs = np.array([[0.0, 0, 320, 240]] if foreground else np.zeros((0, 4)))
        self.presence.announce(self.tracks, reported, blobs, self.now_ns, log)
        rows = log.rows()
        return [*zip(map(EventCode, rows.event.tolist()), rows.track_id.tolist())]

    def hold(self, count, *targets, **options):
        return [event for _ in range(count) for event in self.show(*targets, **options)]


@pytest.fixture
def camera(mapping):
    return Camera(mapping)


INSIDE, OUTSIDE = (7, 0.0, 0.0), (7, 900.0, 900.0)


def test_a_target_known_before_this_camera_asked_enters(camera):
    assert camera.hold(5, INSIDE) == [(EventCode.ENTER, 7)]
    camera.begin(track_id=7)
    assert camera.hold(20, INSIDE) == []


def test_a_target_first_told_of_in_view_is_new(camera):
    camera.show()
    assert camera.hold(20, INSIDE) == [(EventCode.NEW, 7)]
    camera.begin(track_id=7)
    assert camera.hold(20, INSIDE) == []


def test_without_foreground_a_target_is_new_by_its_track(camera):
    camera.show()
    camera.begin()
    assert camera.hold(4, INSIDE, foreground=False) == []
    camera.tracks.track_id[:] = 7
    assert camera.hold(20, INSIDE, foreground=False) == [(EventCode.NEW, 7)]


def test_one_who_was_lost_is_not_new_by_another_id(camera):
    camera.show()
    camera.hold(50, INSIDE)
    camera.hold(50)
    assert camera.hold(20, (9, 2.0, 0.0)) == []


def test_one_who_was_lost_far_away_is_not_he(camera):
    camera.show()
    camera.hold(50, INSIDE)
    camera.show()
    assert camera.hold(20, (9, 3.0, 0.0)) == [(EventCode.NEW, 9)]


def test_one_who_turns_up_beside_another_was_hidden_by_him(camera):
    camera.show()
    camera.hold(50, INSIDE)
    assert camera.hold(20, INSIDE, (9, 2.0, 0.0)) == []


def test_at_first_all_are_new_however_near(camera):
    camera.show()
    reported = camera.hold(10, INSIDE, (9, 0.8, 0.0))
    assert reported == [(EventCode.NEW, 7), (EventCode.NEW, 9)]


def test_of_what_the_server_makes_no_target_nothing_is_told(camera):
    camera.begin()
    assert camera.hold(100) == []
    log = EventLog(camera.now_ns)
    camera.presence.left(camera.tracks, 0, log)
    assert len(log.rows()) == 0


def test_a_track_that_nobody_knows_is_new_once_the_server_has_been_silent_for_long(camera):
    camera.hold(1)
    camera.begin()
    assert camera.hold(49, feedback=False) == []
    assert camera.hold(20, feedback=False) == [(EventCode.NEW, 0)]


def test_without_feedback_a_track_is_new_at_once(camera):
    camera.begin()
    assert camera.show(feedback=False) == [(EventCode.NEW, 0)]


def test_another_track_of_who_is_in_view_is_no_event(camera):
    camera.begin(track_id=7)
    camera.hold(20, INSIDE)
    camera.tracks.clear()
    camera.hold(3, INSIDE)
    camera.begin(track_id=7)
    assert camera.hold(20, INSIDE) == []


def test_who_comes_from_outside_enters_where_there_is_foreground(camera):
    camera.hold(5, OUTSIDE)
    assert camera.hold(20, INSIDE, foreground=False) == []
    assert camera.hold(20, INSIDE) == [(EventCode.ENTER, 7)]
    camera.begin(track_id=7)
    assert camera.hold(20, INSIDE) == []


def test_who_stays_outside_leaves_once_though_a_track_stands_for_him(camera):
    camera.begin(track_id=7)
    camera.hold(5, INSIDE)
    assert camera.hold(60, OUTSIDE) == [(EventCode.EXIT, 7)]


def test_a_lost_target_seen_outside_has_left_and_may_enter_again(camera):
    camera.hold(23, INSIDE)
    assert camera.hold(9, OUTSIDE) == []
    assert camera.hold(5, OUTSIDE) == [(EventCode.EXIT, 7)]
    assert camera.hold(5, INSIDE) == [(EventCode.ENTER, 7)]


def test_who_leaves_unknown_to_the_server_leaves_by_the_own_track(camera):
    camera.begin()
    camera.hold(60, feedback=False)
    log = EventLog(camera.now_ns)
    camera.presence.left(camera.tracks, 0, log)
    assert log.rows().event.tolist() == [EventCode.EXIT]
    camera.tracks.clear()
    assert camera.hold(30) == []


def test_who_was_told_as_left_does_not_leave_again_with_his_track(camera):
    camera.begin(track_id=7)
    camera.hold(5, INSIDE)
    assert camera.hold(30, OUTSIDE) == [(EventCode.EXIT, 7)]
    log = EventLog(camera.now_ns)
    camera.presence.left(camera.tracks, 0, log)
    assert len(log.rows()) == 0


def test_a_target_that_the_server_forgot_leaves_no_trace(camera):
    camera.begin(track_id=7)
    camera.hold(20, INSIDE)
    camera.tracks.clear()
    assert camera.hold(30) == []
    assert not camera.presence._present_ns
    assert not camera.presence._place
