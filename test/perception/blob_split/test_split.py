import numpy as np
import pytest

from mctrack_ros.perception.blob_split.measurements import LEAST_OWN_SHARE
from mctrack_ros.perception.blob_split.split import partition
from mctrack_ros.perception.blob_split.types import Members
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.tracking.appearance import NO_BALANCE, colour_templates

GREEN, RED, BLUE = (60, 120, 60), (30, 30, 220), (220, 60, 30)


class Crowd:
    """People drawn into an image, the far ones first, and the blob that they make."""

    def __init__(self, mapping, people):
        self.sizes = SizeTable(mapping)
        self.image = np.full((240, 320, 3), GREEN, np.uint8)
        self.mask = np.zeros((240, 320), np.uint8)
        self.boxes = []
        for (x, y), colour in sorted(people, key=lambda one: -one[0][1]):
            foot = mapping.image_from_ground([[x, y]])
            box = np.rint(self.sizes.box_of(foot, np.array([[0.5, 1.75]]))[0]).astype(int)
            left, top, width, height = box
            self.image[top : top + height, left : left + width] = colour
            self.mask[top : top + height, left : left + width] = 255
            self.boxes.append(box)
        self.boxes = np.array(self.boxes, float)
        low = self.boxes[:, :2].min(axis=0)
        self.blob = np.concatenate(
            [low, (self.boxes[:, :2] + self.boxes[:, 2:]).max(axis=0) - low]
        )

    @property
    def bottom(self):
        return self.boxes[:, :2] + self.boxes[:, 2:] * [0.5, 1.0]

    def split(self, predicted, templates=None, spread=25.0):
        count = len(predicted)
        members = Members(
            np.zeros(count, np.int64),
            np.asarray(predicted, float).reshape(-1, 2),
            np.tile(np.eye(2) * spread, (count, 1, 1)),
            np.tile([0.6, 1.75], (count, 1)),
            np.zeros((count, 48)) if templates is None else templates,
        )
        background = np.zeros_like(self.image)
        masks = self.mask, self.mask, self.mask
        frame = Frame(self.image, *masks, background, self.mask, 1.0, NO_BALANCE)
        return partition(frame, self.blob[None], self.sizes, members, 1.75)


def bottoms(bodies):
    return bodies.box[:, :2] + bodies.box[:, 2:] * [0.5, 1.0]


def test_members_are_moved_from_their_predictions_to_the_foreground(mapping):
    crowd = Crowd(mapping, [((-0.4, 0.3), RED), ((0.4, 0.0), BLUE)])
    bodies = crowd.split(np.add(crowd.bottom, [4.0, 3.0]))
    assert np.abs(bottoms(bodies) - crowd.bottom).max() < 3.0
    assert (bodies.visible > 0.7).all()


def test_strangers_in_a_wide_blob_are_found(mapping):
    crowd = Crowd(mapping, [((-0.4, 0.0), RED), ((0.3, 0.0), BLUE)])
    bodies = crowd.split([])
    found = bottoms(bodies)[np.argsort(bodies.box[:, 0])]
    assert np.abs(found - crowd.bottom[np.argsort(crowd.boxes[:, 0])]).max() < 3.0


def test_one_person_is_not_made_two(mapping):
    assert len(Crowd(mapping, [((0.0, 0.0), RED)]).split([]).box) == 1


def test_who_stands_behind_is_seen_in_part(mapping):
    crowd = Crowd(mapping, [((0.0, 1.5), RED), ((0.1, 0.0), BLUE)])
    bodies = crowd.split(crowd.bottom)
    assert bodies.visible[0] < 0.8 < bodies.visible[1]


def test_the_second_of_two_tracks_on_one_person_proves_nothing(mapping):
    crowd = Crowd(mapping, [((0.0, 0.0), RED)])
    bodies = crowd.split(np.add(crowd.bottom, [[0.0, 0.0], [1.0, 1.0]]))
    assert bodies.own_share[0] > 0.8
    assert bodies.own_share[1] < LEAST_OWN_SHARE


@pytest.mark.parametrize('order', [(0, 1), (1, 0)])
def test_colours_tell_who_is_who_where_predictions_do_not(mapping, order):
    crowd = Crowd(mapping, [((-0.35, 0.1), RED), ((0.35, 0.0), BLUE)])
    templates = colour_templates(crowd.image, crowd.mask, crowd.boxes.astype(int))[list(order)]
    middle = crowd.bottom.mean(axis=0)
    bodies = crowd.split([middle, middle], templates, spread=100.0)
    assert np.abs(bottoms(bodies) - crowd.bottom[list(order)]).max() < 5.0


def test_same_input_gives_the_same_bodies(mapping):
    crowd = Crowd(mapping, [((-0.4, 0.3), RED), ((0.4, 0.0), BLUE), ((0.0, 0.8), RED)])
    first, second = crowd.split(crowd.bottom), crowd.split(crowd.bottom)
    assert np.array_equal(first.box, second.box)
    assert np.array_equal(first.visible, second.visible)


def test_colours_are_those_of_what_is_seen_of_each(mapping):
    crowd = Crowd(mapping, [((0.0, 1.5), RED), ((0.1, 0.0), BLUE)])
    bodies = crowd.split(crowd.bottom)
    own = colour_templates(crowd.image, crowd.mask, crowd.boxes.astype(int))[1]
    behind, before = bodies.template
    assert np.abs(before - own).sum() < 0.2
    assert np.abs(behind - own).sum() > 1.0
    assert bodies.template.sum(axis=1) == pytest.approx(1.0)
