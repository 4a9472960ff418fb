import numpy as np

from mctrack_ros.perception.ghosts import GhostConfig, heal_ghosts

BOX = np.array([[10, 8, 8, 20]])


def scene(person):
    image = np.full((40, 60, 3), 90, np.uint8)
    if person:
        image[8:28, 10:18] = 200
    mask = np.zeros((40, 60), np.uint8)
    mask[8:28, 10:18] = 255
    return image, mask


def test_hole_in_the_background_is_filled():
    model, mask = scene(person=True)
    image, _ = scene(person=False)
    assert heal_ghosts(model, image, mask, BOX, GhostConfig()).tolist() == [True]
    assert np.array_equal(model, image)


def test_real_object_stays_out_of_the_background():
    model, mask = scene(person=False)
    image, _ = scene(person=True)
    assert heal_ghosts(model, image, mask, BOX, GhostConfig()).tolist() == [False]
    assert (model == 90).all()


def test_ghost_at_the_edge_of_the_picture_is_found():
    model, mask = (part[8:, 10:].copy() for part in scene(person=True))
    image = scene(person=False)[0][8:, 10:].copy()
    box = np.array([[0, 0, 8, 20]])
    assert heal_ghosts(model, image, mask, box, GhostConfig()).tolist() == [True]
