import dataclasses

import cv2
import numpy as np
import pytest

from lens_cameras import SIZE, camera, seen_grid
from mctrack_ros.ground import Camera, CameraMapping
from mctrack_ros.ground.camera.pinhole import PARAMETERS

LENSES = [
    (0, 0, 0, 0, 0),
    (-0.2, 0, 0, 0, 0),
    (-0.25, 0.08, 1e-3, -2e-3, 0.01),
    (0.15, 0, 0, 0, 0),
    (0.1, 0.02, 1e-3, -2e-3, 0.001, 0.3, 0.05, 0.002),
]


@pytest.mark.parametrize('lens', LENSES)
def test_pixels_are_those_of_opencv(lens):
    mapping = camera(distortion=lens)
    points = seen_grid(mapping)
    world = np.column_stack([points, np.linspace(0, 2, len(points))])
    inner = mapping.camera
    across, down, x, y = inner.intrinsics
    matrix = np.array([[across, 0, x], [0, down, y], [0, 0, 1.0]])
    turn = cv2.Rodrigues(inner.rotation)[0]
    expected = cv2.projectPoints(world, turn, inner.translation, matrix, inner.distortion)[0][:, 0]
    found = mapping.image_from_ground(points, world[:, 2])
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize('lens', LENSES)
def test_ground_to_image_and_back(lens):
    mapping = camera(distortion=lens)
    points = seen_grid(mapping)
    assert len(points) > 50
    back = mapping.ground_from_image(mapping.image_from_ground(points))
    np.testing.assert_allclose(back, points, atol=1e-7)


@pytest.mark.parametrize('lens', LENSES)
def test_derivatives_agree_with_differences(lens):
    mapping = camera(distortion=lens)
    points, step = seen_grid(mapping), 1e-5
    for axis in range(2):
        moved = np.eye(2)[axis] * step
        ahead, behind = (
            mapping.image_from_ground(points + moved),
            mapping.image_from_ground(points - moved),
        )
        expected = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(mapping.image_jacobian(points)[:, :, axis], expected, rtol=1e-5)


def _changed(inner, index, step):
    """Return a camera with one of its `PARAMETERS` changed."""
    intrinsics, lens, translation = (
        inner.intrinsics.copy(), inner.distortion.copy(), inner.translation.copy()
    )  # fmt: skip
    rotation = inner.rotation
    if index == 0:
        intrinsics[1] *= 1 + step / intrinsics[0]
        intrinsics[0] += step
    elif index == 1:
        lens[0] += step
    elif index < 5:
        rotation = cv2.Rodrigues(np.eye(3)[index - 2] * step)[0] @ rotation
    elif index < 8:
        translation[index - 5] += step
    elif index < 10:
        intrinsics[index - 6] += step
    elif index == 10:
        intrinsics[1] += intrinsics[0] * step
    else:
        lens[index - 10] += step
    return CameraMapping(Camera(intrinsics, lens, rotation, translation), SIZE)


@pytest.mark.parametrize('index', range(len(PARAMETERS)), ids=PARAMETERS)
def test_derivatives_by_the_camera_agree_with_differences(index):
    inner, step = camera(distortion=(-0.25, 0.08, 1e-3, -2e-3, 0.01)).camera, 1e-6
    mapping = CameraMapping(dataclasses.replace(inner, intrinsics=[650, 660, 352, 301.0]), SIZE)
    points = seen_grid(mapping)
    ahead, behind = (
        _changed(mapping.camera, index, sign * step).image_from_ground(points) for sign in (1, -1)
    )
    expected = (ahead - behind) / (2 * step)
    found = mapping.parameter_jacobian(points)[:, :, index]
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize('index', [1, 11, 14], ids=['k1', 'k2', 'k3'])
def test_derivatives_by_radial_terms_hold_for_a_lens_with_a_denominator(index):
    lens = (0.1, 0.02, 0, 0, 0.001, 0.3, 0.05, 0.002)
    mapping, step = camera(distortion=lens), 1e-6
    points = seen_grid(mapping)
    ahead, behind = (
        _changed(mapping.camera, index, sign * step).image_from_ground(points) for sign in (1, -1)
    )
    expected = (ahead - behind) / (2 * step)
    found = mapping.parameter_jacobian(points)[:, :, index]
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())


def test_covariance_is_that_of_pixels_thrown_at_random():
    mapping = camera()
    point = np.array([[4.0, 10.0]])
    noise = np.array([[0.5, 0.1], [0.1, 0.3]])
    thrown = np.random.default_rng(1).multivariate_normal(
        mapping.image_from_ground(point)[0], noise, 20_000
    )
    expected = np.cov(mapping.ground_from_image(thrown).T)
    np.testing.assert_allclose(mapping.ground_covariance(point, noise)[0], expected, rtol=0.05)
    back = mapping.image_covariance(point, mapping.ground_covariance(point, noise))
    np.testing.assert_allclose(back[0], noise)


def test_what_a_camera_cannot_see_is_nan():
    mapping = camera()
    assert np.isnan(mapping.ground_from_image([[360.0, 0.0]])).all()
    assert np.isnan(mapping.image_from_ground([[3.0, -200.0]])).all()
    assert np.isnan(mapping.image_from_ground([[400.0, 0.0]])).all()
    assert np.isnan(mapping.ground_from_image([[np.nan, 3.0]])).all()
    assert mapping.ground_from_image(np.zeros((0, 2))).shape == (0, 2)


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        ({'intrinsics': np.array([0, 650.0, 1, 1])}, 'focal lengths'),
        ({'intrinsics': np.array([650.0, 650.0])}, r'shape \(2,\)'),
        ({'rotation': 2 * np.eye(3)}, 'orthonormal'),
        ({'translation': np.array([np.nan, 0, 0])}, 'finite'),
    ],
)
def test_what_is_no_camera_is_refused(change, reason):
    inner = camera().camera
    values = {
        name: getattr(inner, name)
        for name in ('intrinsics', 'distortion', 'rotation', 'translation')
    }
    with pytest.raises(ValueError, match=reason):
        Camera(**values | change)
