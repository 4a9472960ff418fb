"""How far lenses are followed, and what they move."""

import cv2
import numpy as np
import pytest

from mctrack_ros.ground.camera.lens import bend_px, distorted, farthest_radius, seen_directions

INTRINSICS = np.array([300.0, 310.0, 300.0, 250.0])
SIZE = (640, 480)
BARREL = np.array([-0.3, 0.0, 0.0, 0.0, 0.0])


def test_a_lens_is_followed_until_it_turns_back():
    """Where the derivative of r (1 + k1 r²) is 0, in every direction."""
    direction, pixel = seen_directions(INTRINSICS, BARREL, SIZE)
    np.testing.assert_allclose(distorted(INTRINSICS, BARREL, direction), pixel)
    radius, turning = np.linalg.norm(direction, axis=1), np.sqrt(1 / 0.9)
    assert radius.max() < turning
    azimuth = np.round(np.degrees(np.arctan2(direction[:, 1], direction[:, 0])) / 7.5).astype(int)
    for one in range(-23, 25):
        assert radius[azimuth == one].max() > 0.99 * turning


def test_what_a_lens_shows_ends_at_the_edges_of_the_image():
    _, pixel = seen_directions(INTRINSICS, np.zeros(5), SIZE)
    assert (pixel >= 0).all()
    assert (pixel <= SIZE).all()
    assert (pixel.min(axis=0) < 10).all()
    assert (pixel.max(axis=0) > np.array(SIZE) - 10).all()


@pytest.mark.parametrize('k1', [-0.03, 0.1])
def test_a_lens_bends_most_in_the_farthest_corner(k1):
    distortion = np.array([k1, 0, 0, 0, 0])
    matrix = np.array([[300.0, 0, 300], [0, 310, 250], [0, 0, 1]])
    corner = np.array([[640.0, 0.0]])
    direction = cv2.undistortPoints(corner[None], matrix, distortion)[0]
    straight = direction * INTRINSICS[:2] + INTRINSICS[2:]
    expected = np.linalg.norm(straight - corner)
    assert 0.8 * expected < bend_px(INTRINSICS, distortion, SIZE) <= expected
    assert bend_px(INTRINSICS, np.zeros(5), SIZE) == 0.0


def test_the_farthest_corner_is_measured_from_the_principal_point():
    assert farthest_radius(INTRINSICS, SIZE) == pytest.approx(np.hypot(340 / 300, 250 / 310))
