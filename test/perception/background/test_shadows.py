import cv2
import numpy as np
import pytest

from mctrack_ros.perception import EventTracker, EventTrackerConfig
from mctrack_ros.perception.background.shadow_pixels import colourfulness
from mctrack_ros.perception.background.shadows import ShadowConfig, Shadows
from sensor_noise import with_noise

PERIOD_NS = 40_000_000
AWAY_FROM_SUN = np.array([0.96, 0.28])
RED, BLUE = (30, 30, 200), (200, 60, 30)
PLACES = np.array([[-3.0, 0.0], [-1.2, 2.0], [0.6, -1.0], [2.2, 1.0]])


class Yard:
    """Textured ground, people on it and what falls from them."""

    def __init__(self, mapping, grey=False):
        self.mapping, self.rng = mapping, np.random.default_rng(1)
        width, height = mapping.image_size
        coarse = self.rng.integers(90, 150, (height // 8, width // 8, 1 if grey else 3))
        ground = np.broadcast_to(coarse, (*coarse.shape[:2], 3)).astype(np.uint8)
        self.ground = cv2.resize(ground, (width, height), interpolation=cv2.INTER_CUBIC)

    def pixels(self, places, height=0.0):
        heights = np.full(len(places), height)
        return np.rint(self.mapping.image_from_ground(places, heights)).astype(np.int32)

    def truth(self, places):
        """Return the bodies and the shadows of people, as masks."""
        bodies, shadows = (np.zeros(self.ground.shape[:2], np.uint8) for _ in range(2))
        beside = np.array([-AWAY_FROM_SUN[1], AWAY_FROM_SUN[0]]) * 0.22
        for place in places:
            tip = place + 1.75 * AWAY_FROM_SUN
            corners = np.array([place - beside, place + beside, tip + beside, tip - beside])
            cv2.fillConvexPoly(shadows, self.pixels(corners), 255)
            (foot,), (head,) = self.pixels(place[None]), self.pixels(place[None], 1.75)
            half = round(self.mapping.width_px(place[None], 0.5)[0] / 2)
            low, high = (foot[0] - half, head[1]), (foot[0] + half, foot[1])
            cv2.rectangle(bodies, low, high, 255, -1)
        return bodies > 0, (shadows > 0) & (bodies == 0)

    def image(self, places, colours, factor):
        """Return people in colours (or in a share of the ground's light) and their shadows."""
        image = self.ground.astype(float)
        image[self.truth(places)[1]] *= factor
        for place, colour in zip(places, colours):
            body = self.truth(place[None])[0]
            image[body] = self.ground[body] * colour if np.isscalar(colour) else colour
        return with_noise(image + 0.5, 2, self.rng)


def watched(yard, colours, factor, steps=60, config=None):
    """Return the shadows' watch, the last foreground as it was and as it is without them."""
    shadows = Shadows(config or ShadowConfig(), yard.mapping, 1.0)
    for step in range(steps):
        places = PLACES + np.array([0.02 * step, 0.0])
        image = yard.image(places, colours, factor)
        mask = ((cv2.absdiff(image, yard.ground).max(axis=2) > 12) * 255).astype(np.uint8)
        before = mask.copy()
        shadows.take_out(image, yard.ground, mask, 2.0, (step + 1) * PERIOD_NS)
    return shadows, before, mask, yard.truth(places)


@pytest.mark.parametrize('factor', [0.5, 0.62, 0.8])
def test_shadows_are_taken_out_and_bodies_left(mapping, factor):
    shadows, before, mask, (bodies, shade) = watched(Yard(mapping), [RED, BLUE] * 2, factor)
    assert shadows.sun @ AWAY_FROM_SUN < -np.cos(np.radians(25))
    assert (before[shade] > 0).mean() > 0.9
    assert (mask[shade] > 0).mean() < 0.15
    assert (mask[bodies] > 0).mean() > 0.97 * (before[bodies] > 0).mean()


def test_without_shadows_dark_clothes_of_the_grounds_colour_are_left(mapping):
    shadows, before, mask, _ = watched(Yard(mapping, grey=True), [0.6, 0.7, 0.6, 0.5], 1.0)
    assert shadows.sun is None
    assert np.array_equal(mask, before)


def test_grey_clothes_are_left_where_others_show_that_there_are_shadows(mapping):
    yard = Yard(mapping, grey=True)
    _, before, mask, (bodies, shade) = watched(yard, [RED, BLUE, (60, 60, 60), RED], 0.6)
    assert (mask[shade] > 0).mean() < 0.15
    assert (mask[bodies] > 0).mean() > 0.9 * (before[bodies] > 0).mean()


def test_belief_ends_with_the_shadows(mapping):
    yard = Yard(mapping)
    shadows, *_ = watched(yard, [RED] * 4, 0.6)
    assert shadows.sun is not None
    for step in range(60, 400):
        image = yard.image(PLACES, [RED] * 4, 1.0)
        mask = ((cv2.absdiff(image, yard.ground).max(axis=2) > 12) * 255).astype(np.uint8)
        shadows.take_out(image, yard.ground, mask, 2.0, (step + 1) * PERIOD_NS)
    assert shadows.sun is None


def test_what_is_switched_off_changes_nothing(mapping):
    off = ShadowConfig(suppress=False)
    shadows, before, mask, _ = watched(Yard(mapping), [RED] * 4, 0.6, config=off)
    assert shadows.sun is None
    assert np.array_equal(mask, before)


def test_what_is_hardly_darker_is_shade_wherever_it_lies_if_so_configured(mapping):
    ground = np.full((480, 640, 3), 100, np.uint8)
    image, mask = ground.copy(), np.zeros(ground.shape[:2], np.uint8)
    for row, grey in enumerate([89, 85, 112]):
        image[100 * row : 100 * row + 50], mask[100 * row : 100 * row + 50] = grey, 255
    shadows = Shadows(ShadowConfig(suppress=False, faint_share=0.13), mapping, 1.0)

    shadows.take_out(image, ground, mask, 1.0, PERIOD_NS)

    assert [bool(mask[100 * row : 100 * row + 50].any()) for row in range(3)] == [
        False,
        True,
        True,
    ]


def test_people_with_shadows_stand_where_their_feet_are(mapping):
    yard = Yard(mapping)
    pipeline = EventTracker(EventTrackerConfig(), mapping, background=yard.ground)
    for step in range(60):
        places = PLACES + np.array([0.02 * step, 0.0])
        image = yard.image(places, [RED, BLUE] * 2, 0.62)
        detections = pipeline.step(image, (step + 1) * PERIOD_NS, None).detections
    found = detections.position[np.argsort(detections.position[:, 0]), :2]
    assert np.allclose(found, places, atol=0.3)
    width = detections.box[:, 2] / mapping.width_px(detections.position[:, :2], 0.5)
    assert (width < 1.2).all()


WALL = {
    'shadow': (0.75, None, True),
    'deep shadow': (0.4, None, False),
    'with a trunk of another colour': (0.75, (60, 90, 160), False),
    'with a brighter upper half': (0.62, 0.85, False),
}


@pytest.mark.parametrize(('factor', 'top', 'is_shade'), WALL.values(), ids=WALL)
def test_what_is_darker_by_one_factor_all_over_is_a_shadow_by_itself(
    mapping, factor, top, is_shade
):
    yard = Yard(mapping)
    image, mask, box, area = standing(yard, factor, top)
    shadows = Shadows(ShadowConfig(), mapping, 1.0)
    assert shadows.alone(image, yard.ground, mask, box, area, 2.0).tolist() == [is_shade]
    off = Shadows(ShadowConfig(suppress=False), mapping, 1.0)
    assert not off.alone(image, yard.ground, mask, box, area, 2.0).any()


def test_in_grey_images_it_may_as_well_be_somebody(mapping):
    yard = Yard(mapping, grey=True)
    image, *seen = standing(yard, 0.75, None)
    grey = np.repeat(image[..., :1], 3, axis=2)
    assert not Shadows(ShadowConfig(), mapping, 1.0).alone(grey, yard.ground, *seen, 2.0).any()


def test_how_colourful_an_image_is_does_not_depend_on_which_channel_is_larger():
    image = np.zeros((32, 48, 3), np.uint8)
    image[:16] = (250, 9, 10)
    image[16:] = (10, 9, 130)
    assert colourfulness(image, 16) == (240 + 120) / 2
    assert colourfulness(image[..., :1].repeat(3, axis=2), 16) == 0


@pytest.mark.parametrize(('top', 'count'), [(None, 0), ((60, 90, 160), 1)])
def test_nobody_is_seen_where_a_shadow_falls_on_a_wall(mapping, top, count):
    yard = Yard(mapping)
    pipeline = EventTracker(EventTrackerConfig(), mapping, background=yard.ground)
    for step in range(20):
        image, *_ = standing(yard, 0.75, top)
        detections = pipeline.step(image, (step + 1) * PERIOD_NS, None).detections
    assert len(detections) == count


def standing(yard, factor, top):
    """Return an image of somebody in a share of the ground's light, his mask, box and area."""
    place = PLACES[:1]
    body = yard.truth(place)[0]
    image = yard.ground.astype(float)
    image[body] *= factor
    rows, columns = np.nonzero(body)
    upper = body & (np.arange(len(body))[:, None] < rows.min() + np.ptp(rows) // 2)
    if top is not None:
        image[upper] = yard.ground[upper] * top if np.isscalar(top) else top
    noisy = image + yard.rng.normal(0, 2, image.shape)
    box = np.array([[columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]], float)
    mask = body.astype(np.uint8) * 255
    area = np.array([float(np.count_nonzero(body))])
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8), mask, box, area


def test_a_clock_that_steps_back_does_not_leave_an_old_sun(mapping):
    yard = Yard(mapping)
    pipeline = EventTracker(EventTrackerConfig(), mapping, background=yard.ground)
    for step in range(60):
        places = PLACES + np.array([0.02 * step, 0.0])
        stamp_ns = 3600_000_000_000 + step * PERIOD_NS
        pipeline.step(yard.image(places, 4 * [RED], 0.55), stamp_ns, None)
    assert pipeline._scene.shadows.sun is not None
    for step in range(1, 11):
        places = PLACES + np.array([0.02 * step, 0.0])
        pipeline.step(yard.image(places, 4 * [RED], 1.0), step * PERIOD_NS, None)
    assert pipeline._scene.shadows.sun is None
