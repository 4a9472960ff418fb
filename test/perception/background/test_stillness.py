import numpy as np
import pytest

from mctrack_ros.perception.background.stillness import GHOST_S, Stillness

PLACE = np.s_[8:28, 10:18]
STILL_S, PERIOD_S = 5.0, 0.2


def scene(person):
    image = np.full((40, 60, 3), 90, np.uint8)
    if person:
        image[PLACE] = 200
    mask = np.zeros((40, 60), np.uint8)
    mask[PLACE] = 255
    return image, mask


def settled_after(model, images, mask, protected=None):
    """Return after what time something became background, s; None: nothing did."""
    stillness = Stillness(STILL_S)
    protected = np.zeros_like(mask) if protected is None else protected
    for index in range(40):
        stillness.note(images(index), mask, 12, PERIOD_S)
        if stillness.settle(images(index), model, mask, protected):
            return index * PERIOD_S
    return None


@pytest.mark.parametrize('protected', [0, 255])
def test_hole_in_the_background_is_filled(protected):
    model, mask = scene(person=True)
    image, _ = scene(person=False)
    found = settled_after(model, lambda index: image, mask, np.full_like(mask, protected))
    assert found == pytest.approx(GHOST_S, abs=PERIOD_S)
    assert np.array_equal(model, image)


def test_what_lies_still_becomes_background_later():
    model, mask = scene(person=False)
    image, _ = scene(person=True)
    assert settled_after(model, lambda index: image, mask) == pytest.approx(STILL_S, abs=PERIOD_S)
    assert np.array_equal(model, image)


def test_who_walked_there_does_not():
    model, mask = scene(person=False)
    image, _ = scene(person=True)
    assert settled_after(model, lambda index: image, mask, mask) is None
    assert (model == 90).all()


def test_hole_at_the_edge_of_the_image_is_filled():
    model, mask = (part[8:, 10:].copy() for part in scene(person=True))
    image = scene(person=False)[0][8:, 10:].copy()
    assert settled_after(model, lambda index: image, mask) is not None


def test_what_sways_or_changes_is_nothing_still():
    model, mask = scene(person=False)
    image, _ = scene(person=True)
    swaying = [np.roll(image, shift, axis=1) for shift in (0, 1, 2, 1)]
    wide = np.zeros_like(mask)
    wide[8:28, 10:20] = 255
    assert settled_after(model, lambda index: swaying[index % 4], wide) is None


def test_the_quiet_part_of_a_body_is_no_thing():
    model, mask = scene(person=False)
    rng = np.random.default_rng(1)
    mask[4:32, 6:22] = 255

    def body(index):
        image = model.copy()
        image[4:32, 6:22] = rng.integers(0, 255, (28, 16, 3))
        image[PLACE] = 200
        return image

    assert settled_after(model.copy(), body, mask) is None
