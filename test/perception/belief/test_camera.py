"""The camera of belief propagation: what it says, and when nothing."""

import numpy as np
import pytest

from drawn_hall import SIZE, image, projection
from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.ground import GroundBelief
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Belief, Detections
from mctrack_ros.perception.background.model import BackgroundConfig
from mctrack_ros.perception.belief.config import LIKELIHOODS, BeliefCameraConfig
from mctrack_ros.perception.belief.histograms import root_templates, squared_distances
from mctrack_ros.perception.belief.observation import box_templates, log_odds
from mctrack_ros.perception.belief.pipeline import BeliefCamera
from mctrack_ros.perception.belief.view import ViewFilters
from mctrack_ros.tracking.appearance import squared_hellinger

PERIOD_NS = 40_000_000
MAPPING = ProjectiveMapping(projection((13.0, 1.0, 7.0)), SIZE)
DARK = np.zeros((240, 320, 3), np.uint8)


def asked(stamp_ns):
    """Return what fusion sends of one target."""
    ground = GroundBelief(BeliefConfig())
    ground.stamp_ns = stamp_ns
    ground.start(1, np.zeros(2), 0.01 * np.eye(2))
    return ground.belief()


def test_a_dark_camera_says_nothing_and_then_goes_on():
    config = BeliefCameraConfig(background=BackgroundConfig(learning_s=0.4))
    camera, rng, told = BeliefCamera(config, 'east', MAPPING), np.random.default_rng(1), []
    for index in range(30):
        stamp_ns = 10**9 + index * PERIOD_NS
        picture = image(MAPPING, np.zeros((int(index > 12), 2)), rng)
        if 20 <= index < 26:
            picture = DARK
        output = camera.step(picture, stamp_ns + PERIOD_NS, asked(stamp_ns))
        told.append(len(output.messages[Belief.TOPIC]))
    assert told[18:] == [200] * 2 + [0] * 6 + [200] * 4
    assert len(output.messages[Detections.TOPIC]) == 1
    assert len(camera.predicted_boxes()) == 1


def test_random_numbers_are_those_of_the_camera_s_name_and_the_stamp():
    picture, sent = image(MAPPING, np.zeros((1, 2)), np.random.default_rng(1)), asked(10**9)
    told = [
        ViewFilters(MAPPING, name).step(picture, stamp_ns, sent).image_state
        for name, stamp_ns in (('a', 2 * 10**9), ('a', 2 * 10**9), ('b', 2 * 10**9), ('a', 10**9))
    ]
    np.testing.assert_array_equal(told[0], told[1])
    assert (told[0] != told[2]).any()
    assert (told[0] != told[3]).any()


def test_a_target_out_of_view_is_not_told_of():
    ground = GroundBelief(BeliefConfig())
    ground.start(1, np.array([40.0, 0.0]), 0.01 * np.eye(2))  # behind the camera
    assert not len(ViewFilters(MAPPING, 'east').step(DARK, PERIOD_NS, ground.belief()))


def on_grass(left=40, colour=(200, 40, 40)):
    """Return a person of one colour on noisy grass, 10 x 30 px, foot at row 50."""
    picture = np.random.default_rng(2).integers(60, 80, (70, 120, 3)).astype(np.uint8)
    picture[..., 1] += 60
    picture[20:50, left : left + 10] = colour
    return picture


def learned(picture, left=40):
    box = np.array([[left - 1, 19, 12, 32]])
    return box_templates(picture, box)


def odds(picture, *boxes):
    """Return the odds of boxes that are drawn with as many about the person, whose mean is his."""
    return log_odds(picture, np.array([boxes], float), learned(on_grass()))[0]


def test_odds_are_one_where_a_target_is_and_about_none_where_a_stranger_is():
    own = (39.0, 19.0, 12.0, 32.0)
    there, beside, grass = odds(
        on_grass(), own, (44.0, 19.0, 12.0, 32.0), (60.0, 19.0, 12.0, 32.0)
    )
    assert there == pytest.approx(1.0, abs=0.25)
    assert beside < 0.7 * there
    assert grass < 0.0
    (stranger,) = odds(on_grass(colour=(40, 40, 200)), own)
    assert stranger < 0.2


def test_integral_histograms_are_those_of_the_boxes():
    picture = np.random.default_rng(2).integers(0, 256, (60, 80, 3), np.uint8)
    box = np.array([[10, 8, 12, 30], [40, 20, 9, 28], [12, 6, 12, 30]], float)
    expected = box_templates(picture, box)
    np.testing.assert_allclose(root_templates(picture, box[None])[0] ** 2, expected, atol=1e-4)
    found = squared_distances(picture, box[None], expected[:1])[0]
    np.testing.assert_allclose(found, squared_hellinger(expected, expected[:1])[:, 0], atol=1e-4)


def test_what_lies_outside_the_image_has_nothing_in_common():
    picture = np.random.default_rng(2).integers(0, 256, (60, 80, 3), np.uint8)
    box = np.array([[[-10, 8, 20, 30], [100, 8, 20, 30], [10, 50, 10, 20]]], float)
    np.testing.assert_allclose(
        (root_templates(picture, box)[0] ** 2).sum(axis=1), [0.5, 0, 0.5], atol=1e-5
    )


def test_a_box_that_is_too_large_or_too_small_has_worse_odds():
    boxes = [(45 - w / 2, 51 - h, w, h) for w, h in ((12, 32), (7, 20), (22, 32), (12, 50))]
    found = odds(on_grass(), *boxes)
    assert found.argmax() == 0


def test_what_lies_outside_the_image_counts_nothing():
    whole, half = odds(on_grass(0), (0.0, 20.0, 10.0, 30.0), (-5.0, 20.0, 10.0, 30.0))
    assert half == pytest.approx(whole / 2, rel=0.1)
    assert not odds(on_grass(), (300.0, 20.0, 10.0, 30.0)).any()


@pytest.mark.parametrize('likelihood', LIKELIHOODS)
def test_a_target_s_own_image_is_the_likeliest(likelihood):
    picture, sent = image(MAPPING, np.zeros((1, 2)), np.random.default_rng(1)), asked(10**9)
    view = ViewFilters(MAPPING, 'east', BeliefCameraConfig(likelihood=likelihood))
    view.step(picture, 10**9 + PERIOD_NS, sent)
    told = view.step(picture, 10**9 + 5 * PERIOD_NS, sent)
    foot = MAPPING.image_from_ground(np.zeros((1, 2)))[0]
    gap = np.hypot(*(told.image_state[:, :2] - foot).T)
    best = gap[np.argsort(told.log_likelihood)[-20:]]
    assert best.mean() < 0.7 * gap.mean()
