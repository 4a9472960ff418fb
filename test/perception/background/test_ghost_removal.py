import numpy as np
import pytest

from mctrack_ros.perception.background.ghost_removal import GhostRemoval

BOX = np.array([[10, 8, 8, 20]])


def scene(person):
    image = np.full((40, 60, 3), 90, np.uint8)
    if person:
        image[8:28, 10:18] = 200
    mask = np.zeros((40, 60), np.uint8)
    mask[8:28, 10:18] = 255
    return image, mask


def watched(model, image, mask, box, times_s=(0.0, 0.5, 1.0)):
    watch = GhostRemoval(settling_s=0.0)
    return [
        watch.look(model, image, mask, box, round(seconds * 1e9)).tolist() for seconds in times_s
    ]


def test_hole_in_the_background_is_filled():
    model, mask = scene(person=True)
    image, _ = scene(person=False)
    assert watched(model, image, mask, BOX) == [[False], [False], [True]]
    assert np.array_equal(model, image)


def test_real_object_stays_out_of_the_background():
    model, mask = scene(person=False)
    image, _ = scene(person=True)
    assert watched(model, image, mask, BOX) == [[False]] * 3
    assert (model == 90).all()


def test_ghost_at_the_edge_of_the_image_is_found():
    model, mask = (part[8:, 10:].copy() for part in scene(person=True))
    image = scene(person=False)[0][8:, 10:].copy()
    box = np.array([[0, 0, 8, 20]])
    assert watched(model, image, mask, box)[-1] == [True]


@pytest.mark.parametrize('step', [0, 8])
def test_only_what_stays_is_healed(step):
    watch, healed = GhostRemoval(settling_s=0.0), []
    for index in range(4):
        model, image = np.full((2, 40, 60, 3), 90, np.uint8)
        mask, left = np.zeros((40, 60), np.uint8), 10 + index * step
        model[8:28, left : left + 8] = 200
        mask[8:28, left : left + 8] = 255
        box = np.array([[left, 8, 8, 20]])
        healed += watch.look(model, image, mask, box, index * 500_000_000).tolist()
    assert any(healed) == (step == 0)
