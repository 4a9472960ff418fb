import numpy as np
import pytest

from mctrack_ros.perception.blobs.frame import Picture
from mctrack_ros.perception.feedback.missed_detections import vacancies
from mctrack_ros.perception.feedback.persons_in_view import Company

STAMP_NS = 10**18
WIDTH, HEIGHT = 80, 60


def company(*people):
    """People are (local id, global id, left edge, px); boxes are 10 x 20 px."""
    local_id = np.array([one[0] for one in people], np.int64)
    track_id = np.array([one[1] for one in people], np.int64)
    box = np.array([(one[2], 20.0, 10, 20) for one in people])
    key = np.where(track_id > 0, track_id, -local_id)
    here = np.zeros((len(people), 2))
    return Company(key, local_id, track_id, here, box, np.zeros(len(people), bool))


def picture(scale=1.0):
    found = np.zeros((round(HEIGHT / scale), round(WIDTH / scale)), np.uint8)
    grey = np.zeros((*found.shape, 3), np.uint8)
    return Picture(grey, found, found.copy(), grey, found, scale)


def told(people, part, shown=None, ignored=None):
    rows = vacancies(company(*people), np.array(part), shown or picture(), ignored, STAMP_NS)
    assert rows.is_vacant.all()
    return rows.track_id.tolist()


@pytest.mark.parametrize('scale', [1.0, 2.0])
def test_a_target_on_bare_background_is_told_with_its_box(scale):
    people = company((0, 7, 30.0))
    rows = vacancies(people, np.array([-1]), picture(scale), None, STAMP_NS)
    assert rows.is_vacant.tolist() == [True]
    assert rows.track_id.tolist() == [7]
    assert rows.box[0].tolist() == [30, 20, 10, 20]
    assert rows.stamp_ns == STAMP_NS


def test_who_is_in_the_foreground_or_has_a_local_track_or_no_id_is_not_vacant():
    assert told([(0, 7, 30.0), (3, 8, 10.0), (4, 0, 50.0)], [2, -1, -1]) == []


def test_a_few_pixels_of_somebody_too_small_to_be_an_object_are_enough():
    shown = picture()
    shown.found[25, 30:39] = 255
    assert told([(0, 7, 30.0)], [-1], shown) == [7]
    shown.found[26, 30:39] = 255
    assert told([(0, 7, 30.0)], [-1], shown) == []


@pytest.mark.parametrize('left', [-1.0, 71.0, np.nan])
def test_who_is_partly_outside_the_picture_is_not_vacant(left):
    assert told([(0, 7, left)], [-1]) == []


def test_where_the_camera_does_not_look_nobody_is_missed():
    ignored = np.full((HEIGHT, WIDTH), 255, np.uint8)
    ignored[39, 39] = 0
    assert told([(0, 7, 30.0), (0, 8, 50.0)], [-1, -1], ignored=ignored) == [8]
