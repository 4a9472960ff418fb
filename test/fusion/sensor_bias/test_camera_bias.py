from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fusion_scenes import detections
from mctrack_ros.fusion import JointConfig, JointTracker
from mctrack_ros.fusion.sensor_bias.camera_bias import SURE, judged
from mctrack_ros.interfaces import CameraDetections, Tick

CAMERAS = ('cam1', 'cam2', 'cam3', 'cam4')
PEOPLE = np.array([[8.0 * column, 8.0 * row] for column in range(4) for row in range(3)])
STEP_NS, SIGMA = 510_000_000, 0.1
EXACT = replace(JointConfig().motion, sensor_sigma=0.001)


class Site:
    """People who stand, and cameras that err as they say, but for what is done to them."""

    def __init__(self, cameras=CAMERAS, seed=1, compare=True):
        motion = replace(EXACT, compare_cameras=compare)
        self.pipeline = JointTracker(replace(JointConfig(), motion=motion), cameras)
        self.cameras, self.rng, self.stamp_ns = cameras, np.random.default_rng(seed), 0

    def run(self, steps, shift=None, scatter=None):
        """Return the mean distance of the tracks from the people in the last step."""
        for _ in range(steps):
            self.stamp_ns += STEP_NS
            frames = []
            for camera in self.cameras:
                places = PEOPLE + self.rng.normal(0, SIGMA, PEOPLE.shape)
                places += (shift or {}).get(camera, 0.0)
                places += self.rng.normal(0, (scatter or {}).get(camera, 0.0), PEOPLE.shape)
                frames.append(CameraDetections(camera, detections(self.stamp_ns, places, SIGMA)))
            self.tracks = self.pipeline.step(Tick.of(frames)).tracks
        apart = np.linalg.norm(self.tracks.position[:, None, :2] - PEOPLE, axis=2)
        return apart.min(axis=0).mean()

    @property
    def bias(self):
        return self.pipeline.bias


def test_honest_cameras_are_left_as_they_are():
    judging, plain = Site(), Site(compare=False)
    for _ in range(40):
        judging.run(1)
        plain.run(1)
        assert np.array_equal(judging.tracks.position, plain.tracks.position)
        assert np.array_equal(judging.tracks.covariance, plain.tracks.covariance)
    assert judging.bias.comparisons(0) > 100
    assert not judging.bias.offset.any()
    assert not judging.bias.variance.any()


@pytest.mark.parametrize('shift', [(0.4, 0.0), (-0.7, 0.7), (1.2, -1.6)])
def test_a_displaced_camera_is_found_and_corrected_and_only_that(shift):
    site = Site()
    site.run(20)
    site.run(30, {'cam2': np.array(shift)})
    assert np.allclose(site.bias.offset[1], shift, atol=0.1)
    assert not site.bias.offset[[0, 2, 3]].any()
    assert not site.bias.variance[[0, 2, 3]].any()
    assert site.run(1, {'cam2': np.array(shift)}) < 0.1


def test_a_camera_that_is_mended_is_believed_again():
    site = Site()
    site.run(30, {'cam2': np.array([1.0, 0.0])})
    assert site.bias.offset[1].any()
    site.run(30)
    assert not site.bias.offset.any()
    assert not site.bias.variance.any()


def test_of_three_cameras_the_majority_is_right():
    site = Site(CAMERAS[:3])
    site.run(20)
    site.run(40, {'cam3': np.array([0.0, 1.0])})
    assert np.allclose(site.bias.offset, [[0, 0], [0, 0], [0, 1]], atol=0.15)


def test_of_two_cameras_nobody_can_say():
    site = Site(CAMERAS[:2])
    site.run(30, {'cam2': np.array([0.4, 0.0])})
    assert not site.bias.offset.any()
    assert not site.bias.variance.any()
    assert site.bias.comparisons(1) == 0


def test_a_camera_that_scatters_more_than_it_says_is_weighed_down():
    site = Site()
    site.run(40, scatter={'cam4': 0.5})
    assert 0.2 < np.sqrt(site.bias.variance[3]) < 0.7
    assert not site.bias.variance[:3].any()
    assert np.linalg.norm(site.bias.offset, axis=1).max() < 0.1


def test_the_same_ticks_give_the_same_judgement():
    sites = [Site(), Site()]
    for site in sites:
        site.run(20, {'cam1': np.array([0.6, 0.0])})
    assert np.array_equal(sites[0].bias.offset, sites[1].bias.offset)
    assert sites[0].bias.offset.any()


def residuals(count, shift=(0.0, 0.0), sigma=SIGMA, seed=0):
    rng = np.random.default_rng(seed)
    covariance = np.tile(SIGMA**2 * np.eye(2), (count, 1, 1))
    return rng.normal(0, sigma, (count, 2)) + shift, covariance


def test_a_third_of_mistaken_pairs_does_not_matter():
    residual, covariance = residuals(120, shift=(0.5, 0.0))
    residual[::3] = np.random.default_rng(1).uniform(-2, 2, (40, 2))
    offset, _ = judged(residual, covariance, SURE)
    assert np.allclose(offset, [0.5, 0.0], atol=0.1)


def test_of_honest_cameras_one_in_hundreds_is_doubted():
    doubted = [judged(*residuals(128, seed=seed), SURE) for seed in range(500)]
    assert np.mean([bool(variance or offset.any()) for offset, variance in doubted]) < 0.005


@given(st.integers(0, 128), st.integers(0, 1000), st.floats(0.0, 2.0), st.floats(0.05, 1.0))
def test_judgement_is_bounded_and_turns_with_the_ground(count, seed, shift, sigma):
    residual, covariance = residuals(count, (shift, -shift), sigma, seed)
    offset, variance = judged(residual, covariance, SURE)
    assert 0 <= variance <= 9
    largest = np.abs(residual).max(axis=0, initial=0.0)
    assert (np.abs(offset) <= largest).all()
    turned, same = judged(np.ascontiguousarray(-residual[:, ::-1]), covariance, SURE)
    assert np.allclose(turned, -offset[::-1])
    assert same == pytest.approx(variance)
