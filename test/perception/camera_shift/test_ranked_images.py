import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mctrack_ros.perception.camera_shift.monitor import RankedImages
from mctrack_ros.perception.camera_shift.patches import Motion


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 3, 5, 9]))
def test_the_median_is_numpys(seed, count):
    images = np.random.default_rng(seed).integers(0, 256, (count, 4, 5), np.uint8)
    ranked = RankedImages()
    for index, image in enumerate(images):
        ranked.add(image, Motion(right=float(index)))
    still, motion = ranked.median()
    assert np.array_equal(still, np.median(images, axis=0))
    assert motion.right == (count - 1) / 2


def test_of_an_even_number_the_brighter_middle_counts():
    ranked = RankedImages()
    for grey in (7, 3, 9, 5):
        ranked.add(np.full((2, 2), grey, np.uint8), Motion())
    assert (ranked.median()[0] == 7).all()


def test_given_images_are_left_alone():
    images = np.random.default_rng(0).integers(0, 256, (3, 4, 5), np.uint8)
    ranked, before = RankedImages(), images.copy()
    for image in images:
        ranked.add(image, Motion())
    assert np.array_equal(images, before)


def test_a_cleared_one_is_empty():
    ranked = RankedImages()
    ranked.add(np.zeros((2, 2), np.uint8), Motion())
    ranked.clear()
    assert len(ranked) == 0
