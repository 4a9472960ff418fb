import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.ground.homography.fit import start_homography

SIZE = (768, 576)


def camera(position=(3.0, -40.0, 15.0), target=(0.0, 10.0, 0.0), focal=900.0):
    """Return a mapping with a principal point at the centre, built from its pose."""
    position = np.asarray(position)
    forward = np.asarray(target) - position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[focal, 0, SIZE[0] / 2], [0, focal, SIZE[1] / 2], [0, 0, 1]])
    matrix = intrinsics @ np.column_stack([rotation, -rotation @ position])
    return ProjectiveMapping(matrix, SIZE)


def ground_points(count=50, seed=0):
    return np.random.default_rng(seed).uniform((-15, -5), (15, 30), (count, 2))


@settings(max_examples=50, deadline=None)
@given(
    x=st.floats(-30, 30),
    height=st.floats(4, 40),
    distance=st.floats(15, 60),
    scale=st.sampled_from([-7.0, -0.01, 0.3, 50.0]),
)
def test_ground_to_image_and_back_for_any_pose_and_any_sign(x, height, distance, scale):
    mapping = camera((x, -distance, height))
    mapping = ProjectiveMapping(mapping.image_from_world * scale, SIZE)
    points = ground_points()
    back = mapping.ground_from_image(mapping.image_from_ground(points))
    np.testing.assert_allclose(back, points, atol=1e-6)


def test_jacobian_agrees_with_differences():
    mapping, points = camera(), ground_points()
    step = 1e-5
    for axis in range(2):
        shift = np.eye(2)[axis] * step
        slope = mapping.image_from_ground(points + shift) - mapping.image_from_ground(
            points - shift
        )
        np.testing.assert_allclose(
            mapping.image_jacobian(points)[:, :, axis], slope / (2 * step), rtol=1e-6
        )


def test_ground_covariance_agrees_with_sampling():
    mapping, point = camera(), np.array([[4.0, 12.0]])
    rng = np.random.default_rng(2)
    pixels = mapping.image_from_ground(point) + rng.normal(0, 0.5, (200_000, 2))
    sampled = np.cov(mapping.ground_from_image(pixels).T)
    np.testing.assert_allclose(
        mapping.ground_covariance(point, 0.25 * np.eye(2))[0], sampled, rtol=0.02, atol=1e-5
    )


def test_the_vertical_is_recovered_from_the_ground_alone():
    truth, points = camera(), ground_points()
    found = ProjectiveMapping.from_points(points, truth.image_from_ground(points), SIZE)
    np.testing.assert_allclose(
        found.image_from_ground(points, 1.8), truth.image_from_ground(points, 1.8), atol=1e-3
    )
    assert (found.height_px(points, 1.8) > 0).all()


def test_what_is_above_the_horizon_has_no_ground_position():
    assert np.isnan(camera().ground_from_image([[384.0, -400.0]])).all()


def test_what_is_behind_the_camera_has_no_pixel():
    assert np.isnan(camera().image_from_ground([[0.0, -200.0]])).all()


def test_few_wrong_points_do_not_spoil_the_fit():
    truth, points = camera(), ground_points()
    pixels = truth.image_from_ground(points)
    pixels[::10] += 80
    found = ProjectiveMapping.from_points(points, pixels, SIZE)
    np.testing.assert_allclose(found.ground_from_image(pixels)[1:10], points[1:10], atol=2e-3)


@pytest.mark.parametrize(
    ('ground', 'reason'),
    [
        (np.zeros((3, 2)), '3 points, expected at least 4'),
        (np.column_stack([np.arange(8.0), np.arange(8.0)]), 'lie on a line'),
    ],
)
def test_points_that_fix_no_homography_are_refused(ground, reason):
    with pytest.raises(ValueError, match=reason):
        ProjectiveMapping.from_points(
            ground, np.random.default_rng(0).normal(size=ground.shape), SIZE
        )


@pytest.mark.parametrize('matrix', [np.zeros((3, 4)), np.full((3, 4), np.nan), np.eye(3)])
def test_impossible_matrices_are_refused(matrix):
    with pytest.raises(ValueError, match=r'singular|finite'):
        ProjectiveMapping(matrix, SIZE)


def leaned(tilt):
    """Return the camera 3 m up that looks down by so many degrees, by its homography alone."""
    away = 3.0 / np.tan(np.radians(tilt))
    known = camera((0.0, -away, 3.0), (0.0, 0.0, 0.0), 600.0)
    return ProjectiveMapping.from_homography(known.image_from_ground_homography, SIZE)


def test_how_high_people_look_is_open_the_steeper_a_camera_looks_down():
    doubts = [leaned(tilt).height_doubt(1.75) for tilt in (20, 45, 60, 80, 85, 89)]
    assert max(doubts[:3]) < 0.05
    assert min(doubts[3:]) > 0.1
    assert doubts[-1] > 1.0


def test_a_known_pose_leaves_nothing_open_and_one_that_no_lens_explains_everything():
    assert camera().height_doubt(1.75) == 0.0
    stretched = leaned(45).image_from_ground_homography @ np.diag([1.0, 3.0, 1.0])
    assert ProjectiveMapping.from_homography(stretched, SIZE).height_doubt(1.75) > 0.1


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000))
def test_points_that_are_off_by_what_is_believed_change_heights_by_what_is_said(seed):
    rng, mapping = np.random.default_rng(seed), leaned(60)
    image = np.array([[0.0, 250], [768, 250], [0, 575], [768, 575]])
    ground = mapping.ground_from_image(image)
    image += rng.normal(0, 0.005 * SIZE[0], image.shape)
    off = ProjectiveMapping.from_homography(start_homography(ground, image), SIZE)
    ratio = off.usual_height_px(1.75) / mapping.usual_height_px(1.75)
    assert abs(ratio - 1.0) < 4 * mapping.height_doubt(1.75)
