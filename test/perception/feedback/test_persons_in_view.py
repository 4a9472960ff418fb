import numpy as np
import pytest

from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception.feedback.persons_in_view import (
    ConfirmedTracks,
    PersonList,
)
from mctrack_ros.perception.geometry.person_size import SizeTable

START_NS, PERIOD_NS = 10**18, 40_000_000
OUTSIDE = (900.0, 900.0)


def tracks(*places, seen=True, own_share=1.0, age_s=1.0):
    """Local tracks 1, 2, ... at (x, y); their boxes are left of them in the image."""
    count = len(places)
    return ConfirmedTracks(
        np.arange(1, count + 1),
        np.array(places, float).reshape(-1, 2),
        np.full((count, 4), 50.0),
        np.full(count, seen),
        np.full(count, own_share),
        np.full(count, age_s),
    )


class Camera:
    def __init__(self, mapping):
        extent = np.array([0.6, 1.75])
        self.persons = PersonList(extent, SizeTable(mapping), mapping)
        self.now_ns = START_NS

    def show(self, local, *targets, feedback=True, after_ns=PERIOD_NS):
        """Advance an image; targets are (id, x, y)."""
        self.now_ns += after_ns
        reported = None
        if feedback:
            position = np.array([[x, y, 0.0] for _, x, y in targets]).reshape(-1, 3)
            ids = [target for target, *_ in targets]
            reported = Feedback.build(self.now_ns - 2 * PERIOD_NS, position=position, track_id=ids)
        return self.persons.update(local, reported, self.now_ns)


@pytest.fixture
def camera(mapping):
    return Camera(mapping)


def test_a_target_without_a_local_track_is_of_the_company(camera):
    in_view = camera.show(tracks(), (7, 0.0, 0.0))
    assert (in_view.key.tolist(), in_view.local_id.tolist()) == ([7], [0])
    assert np.isfinite(in_view.box).all()


def test_a_target_and_the_local_track_beside_it_are_one(camera):
    local = tracks((0.3, 0.0))
    in_view = camera.show(local, (7, 0.0, 0.0))
    assert (in_view.key.tolist(), in_view.local_id.tolist()) == ([7], [1])
    assert np.array_equal(in_view.box, local.box)


def test_a_sure_local_track_that_the_fusion_node_misses_is_a_person(camera):
    in_view = camera.show(tracks((3.0, 0.0)), (7, 0.0, 0.0))
    assert (in_view.key.tolist(), in_view.local_id.tolist()) == ([-1, 7], [1, 0])


@pytest.mark.parametrize('doubt', [{'seen': False}, {'own_share': 0.1}, {'age_s': 0.1}])
def test_a_doubtful_local_track_that_the_fusion_node_misses_is_nobody(camera, doubt):
    assert camera.show(tracks((3.0, 0.0), **doubt), (7, 0.0, 0.0)).key.tolist() == [7]


def test_a_target_out_of_the_image_is_not_of_the_company(camera):
    assert camera.show(tracks(), (7, *OUTSIDE)).key.tolist() == []


def test_who_steps_into_the_image_came_just_then(camera):
    camera.show(tracks(), (7, *OUTSIDE), (8, 0.0, 0.0))
    came = [camera.show(tracks(), (7, 0.0, 0.0), (8, 0.0, 0.0)).came.tolist() for _ in range(2)]
    assert came == [[True, False], [False, False]]


def test_without_new_feedback_the_last_counts_for_a_while(camera):
    camera.show(tracks(), (7, 0.0, 0.0))
    assert camera.show(tracks(), feedback=False).key.tolist() == [7]
    assert camera.show(tracks(), feedback=False, after_ns=10**9).key.tolist() == []


def test_without_a_fusion_node_all_local_tracks_are_the_company(camera):
    in_view = camera.show(tracks((0.0, 0.0), OUTSIDE, own_share=0.0, age_s=0.0), feedback=False)
    assert (in_view.key.tolist(), in_view.local_id.tolist()) == ([-2, -1], [2, 1])
