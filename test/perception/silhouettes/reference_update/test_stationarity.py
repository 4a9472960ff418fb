import numpy as np

from mctrack_ros.perception.background.model import Background, BackgroundConfig
from mctrack_ros.perception.silhouettes.reference_update.stationarity import Stationarity

PERIOD_NS = 250_000_000
ALL = np.s_[:, :]


def watched(values, mask=255):
    still = Stationarity(0.2)
    for index, value in enumerate(values):
        image = np.full((4, 6, 3), value, np.uint8)
        still.watch(image, np.full((4, 6), mask, np.uint8), index * PERIOD_NS, 5.0)
    return still, image


def test_time_grows_while_a_pixel_looks_the_same():
    still, image = watched([80, 80, 83, 78, 80, 81])

    assert np.allclose(still.seconds, 1.0, atol=1e-3)
    assert still.still_for(image, ALL, 0.9).all()
    assert not still.still_for(image, ALL, 1.2).any()


def test_somebody_who_passes_does_not_undo_it():
    still, image = watched([80] * 14 + [120] * 3 + [80])

    assert (still.image == 80).all()
    assert still.still_for(image, ALL, 2.0).all()


def test_what_is_hidden_just_now_is_not_still():
    still, image = watched([80] * 14 + [120])

    assert not still.still_for(image, ALL, 2.0).any()


def test_what_stays_takes_the_place_of_what_was():
    still, _ = watched([80] * 6 + [120] * 20)

    assert (still.image == 120).all()


def test_background_is_never_still():
    still, _ = watched([80] * 9, mask=0)

    assert (still.seconds == 0.0).all()


def test_images_that_come_sooner_are_not_looked_at():
    still = Stationarity(0.2)
    image, mask = np.zeros((4, 6, 3), np.uint8), np.full((4, 6), 255, np.uint8)

    looked = [still.watch(image, mask, index * 40_000_000, 5.0) for index in range(11)]

    assert sum(looked) == 3


def test_old_pixels_alone_are_taught():
    background = Background(BackgroundConfig())
    background.begin(np.full((4, 6, 3), 100, np.uint8))
    still, mask = Stationarity(0.2), np.zeros((4, 6), np.uint8)
    mask[1] = 255
    image = np.full((4, 6, 3), 100, np.uint8)
    image[1] = 60
    for index in range(10):
        still.watch(image, mask, index * PERIOD_NS, 5.0)

    still.teach(background, image, 5.0)
    assert (background.model == 100).all()

    still.teach(background, image, 2.0)
    assert (background.model[1] == 60).all()
    assert (background.model[[0, 2, 3]] == 100).all()
    assert (still.seconds == 0.0).all()


def test_skipping_what_is_quiet_changes_nothing():
    rng, shape = np.random.default_rng(3), (9, 75)
    still, seconds, known = Stationarity(0.2), np.zeros(shape, np.float32), None
    for index in range(40):
        image = rng.integers(60, 70, (*shape, 3)).astype(np.uint8)
        mask = np.zeros(shape, np.uint8)
        mask[2:4, 30:40] = mask[rng.integers(9)] = 255 * (index % 3 > 0)
        still.watch(image, mask, index * PERIOD_NS, 5.0)
        if known is None:
            known = image.astype(np.float32)
            continue
        alike = np.abs(image - known).max(axis=2) <= 5.0
        shown, same = mask > 0, (seconds > 0) & alike
        longer, shorter = seconds + 0.25, np.float32(seconds - 0.25)
        fresh = shown & ~same & (seconds <= 0.25)
        known = np.where((shown & same)[..., None], known + 0.25 * (image - known), known)
        known = np.where(fresh[..., None], image, known).astype(np.float32)
        seconds = np.where(shown & same, longer, np.maximum(shorter, 0)).astype(np.float32)
        seconds[fresh] = 1e-6

    assert np.array_equal(still.seconds, seconds)
    assert np.allclose(still.image, known)
    assert seconds.max() > 1.0
