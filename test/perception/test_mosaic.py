import numpy as np
import pytest

from mctrack_ros.interfaces import Detections, Events, Foreground
from mctrack_ros.perception import CameraShift
from mctrack_ros.perception.mosaic import HEADS, without_faces
from mctrack_ros.perception.output import CameraOutput

HEIGHT, WIDTH = 180, 240
IMAGE = np.random.default_rng(3).integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)
NOBODY = np.zeros((0, 4))
BOX = [100, 60, 20, 70]
CELL = 10
MASK = np.zeros((HEIGHT // 4, WIDTH // 4), np.uint8)


def output(boxes=(), mask=MASK, blind=False, settled=True):
    seen = Detections.blind(1) if blind else Detections.build(1, box=np.reshape(boxes, (-1, 4)))
    messages = {Detections.TOPIC: seen}
    if mask is not None:
        messages[Foreground.TOPIC] = Foreground(1, mask)
    return CameraOutput(messages, Events.build(1), CameraShift(), settled)


def part(image, box, margin=0):
    left, top, width, height = box
    return image[
        max(top - margin, 0) : top + height + margin, max(left - margin, 0) : left + width + margin
    ]


def is_gone(shown, box):
    """Tell whether a box holds at most as many colours as it touches cells."""
    colours = np.unique(part(shown, box).reshape(-1, 3), axis=0)
    cells = (box[2] / CELL + 2) * (box[3] / CELL + 2)
    return len(colours) <= cells and part(shown, box).std() < 0.4 * part(IMAGE, box).std()


@pytest.mark.parametrize('found', ['detected', 'predicted', 'foreground'])
def test_no_detail_is_left_of_people_and_all_of_the_rest(found):
    mask = MASK.copy()
    if found == 'foreground':
        part(mask, [value // 4 for value in BOX])[:] = 255
    seen = output([BOX] if found == 'detected' else [], mask)
    more = np.array([BOX, [np.nan] * 4]) if found == 'predicted' else NOBODY
    original = IMAGE.copy()
    shown = without_faces(IMAGE, seen, more)
    assert np.array_equal(original, IMAGE)
    assert is_gone(shown, BOX)
    same = (shown == IMAGE).all(axis=2)
    part(same, BOX, CELL + 4)[:] = True
    assert same.all()


def test_a_face_is_one_colour_however_near_the_person():
    box = [60, 0, 70, 180]
    shown = without_faces(IMAGE, output([box]), NOBODY)
    head = [75, 0, 24, 180 // HEADS]
    assert len(np.unique(part(shown, head).reshape(-1, 3), axis=0)) <= 4


def test_boxes_that_reach_beyond_the_image_are_hidden_as_far_as_they_are_in_it():
    shown = without_faces(IMAGE, output([[-15, 150, 40, 70], [300, 10, 5, 30]]), NOBODY)
    assert is_gone(shown, [0, 150, 25, 30])
    assert np.array_equal(shown[:100], IMAGE[:100])


@pytest.mark.parametrize(
    'unknown', [{'blind': True}, {'settled': False}, {'mask': np.zeros((0, 0), np.uint8)}]
)
def test_what_cannot_be_told_apart_is_hidden_as_a_whole(unknown):
    shown = without_faces(IMAGE, output(**unknown), NOBODY)
    assert is_gone(shown, [0, 0, WIDTH, HEIGHT])


def test_nobody_leaves_the_image_as_it_is():
    assert np.array_equal(without_faces(IMAGE, output(), NOBODY), IMAGE)
    assert np.array_equal(without_faces(IMAGE, output(mask=None), NOBODY), IMAGE)
