import numpy as np
import pytest

from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.feedback.missed_detections import missed_detections
from mctrack_ros.perception.feedback.persons_in_view import PersonsInView
from mctrack_ros.tracking.appearance import NO_BALANCE

STAMP_NS = 10**18
WIDTH, HEIGHT = 80, 60


def in_view(*people):
    """People are (local id, global id, left edge, px); boxes are 10 x 20 px."""
    local_id = np.array([one[0] for one in people], np.int64)
    track_id = np.array([one[1] for one in people], np.int64)
    box = np.array([(one[2], 20.0, 10, 20) for one in people])
    key = np.where(track_id > 0, track_id, -local_id)
    here = np.zeros((len(people), 2))
    return PersonsInView(key, local_id, track_id, here, box, np.zeros(len(people), bool))


def frame(scale=1.0):
    found = np.zeros((round(HEIGHT / scale), round(WIDTH / scale)), np.uint8)
    grey = np.zeros((*found.shape, 3), np.uint8)
    return Frame(grey, found, found.copy(), found, grey, found, scale, NO_BALANCE)


def reported(people, part, shown=None, ignored=None):
    rows = missed_detections(in_view(*people), np.array(part), shown or frame(), ignored, STAMP_NS)
    assert rows.is_vacant.all()
    return rows.track_id.tolist()


@pytest.mark.parametrize('scale', [1.0, 2.0])
def test_a_target_on_bare_background_is_told_with_its_box(scale):
    people = in_view((0, 7, 30.0))
    rows = missed_detections(people, np.array([-1]), frame(scale), None, STAMP_NS)
    assert rows.is_vacant.tolist() == [True]
    assert rows.track_id.tolist() == [7]
    assert rows.box[0].tolist() == [30, 20, 10, 20]
    assert rows.stamp_ns == STAMP_NS


def test_who_is_in_the_foreground_or_has_a_local_track_or_no_id_is_not_vacant():
    assert reported([(0, 7, 30.0), (3, 8, 10.0), (4, 0, 50.0)], [2, -1, -1]) == []


def test_a_few_pixels_of_somebody_too_small_to_be_an_object_are_enough():
    shown = frame()
    shown.found[25, 30:39] = 255
    assert reported([(0, 7, 30.0)], [-1], shown) == [7]
    shown.found[26, 30:39] = 255
    assert reported([(0, 7, 30.0)], [-1], shown) == []


@pytest.mark.parametrize('left', [-1.0, 71.0, np.nan])
def test_who_is_partly_outside_the_image_is_not_vacant(left):
    assert reported([(0, 7, left)], [-1]) == []


def test_where_the_camera_does_not_look_nobody_is_missed():
    ignored = np.full((HEIGHT, WIDTH), 255, np.uint8)
    ignored[39, 39] = 0
    assert reported([(0, 7, 30.0), (0, 8, 50.0)], [-1, -1], ignored=ignored) == [8]
