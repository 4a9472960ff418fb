"""The camera of belief propagation: what it says, and when nothing."""

import numpy as np

from drawn_hall import SIZE, image, projection
from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.ground import GroundBelief
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Belief, Detections
from mctrack_ros.perception.background.model import BackgroundConfig
from mctrack_ros.perception.belief.config import BeliefCameraConfig
from mctrack_ros.perception.belief.observation import root_templates
from mctrack_ros.perception.belief.pipeline import BeliefCamera
from mctrack_ros.perception.belief.view import ViewFilters
from mctrack_ros.tracking.appearance import bhattacharyya_distance, colour_templates

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


def test_templates_of_whole_boxes_are_those_of_the_detections():
    picture = np.random.default_rng(2).integers(0, 256, (60, 80, 3), np.uint8)
    box = np.array([[10, 8, 12, 30], [40, 20, 9, 28], [12, 6, 12, 30]])
    expected = colour_templates(picture, np.full((60, 80), 255, np.uint8), box)
    found = root_templates(picture, box[None].astype(float))[0] ** 2
    assert np.diag(bhattacharyya_distance(found, expected)).max() < 0.2


def test_what_lies_outside_the_image_has_nothing_in_common():
    picture = np.random.default_rng(2).integers(0, 256, (60, 80, 3), np.uint8)
    box = np.array([[[-10, 8, 20, 30], [100, 8, 20, 30], [10, 50, 10, 20]]], float)
    np.testing.assert_allclose(
        (root_templates(picture, box)[0] ** 2).sum(axis=1), [0.5, 0, 0.5], atol=1e-5
    )


def test_a_target_s_own_image_is_the_likeliest():
    picture, sent = image(MAPPING, np.zeros((1, 2)), np.random.default_rng(1)), asked(10**9)
    view = ViewFilters(MAPPING, 'east')
    view.step(picture, 10**9 + PERIOD_NS, sent)
    told = view.step(picture, 10**9 + 5 * PERIOD_NS, sent)
    foot = MAPPING.image_from_ground(np.zeros((1, 2)))[0]
    gap = np.hypot(*(told.image_state[:, :2] - foot).T)
    best = gap[np.argsort(told.log_likelihood)[-20:]]
    assert best.mean() < 0.7 * gap.mean()
