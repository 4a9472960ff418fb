"""Files after public trouble reports, in the folder `faults` beside the real data."""

import cv2
import numpy as np
import pytest

from mctrack_ros.ground import CalibrationError, read_calibration, read_camera

WIDE, NARROW = (1640, 1232), (1280, 720)
FISHEYE = np.array([0.1757, -0.0318, 0.0004, -0.0007])
FISHEYE_MATRIX = np.array([[404.0, 0, 871.2], [0, 404.7, 597.4], [0, 0, 1]])
LENS = np.array([-0.31, 0.11, 0.0006, -0.0004, -0.018])
MATRIX = np.array([[620.0, 0, 640], [0, 620, 360], [0, 0, 1]])
RVEC, TVEC = np.array([2.1587989303424648, 0, 0]), np.array([0, 0, 7.2111025509279791])
POSES = ['tf.yaml', 'interactive_pose.xml']


@pytest.fixture(scope='module')
def files(data_root):
    folder = data_root.parent / 'faults' / 'calibration'
    if not folder.is_dir():
        pytest.skip(f'reported files left out: no {folder}')
    return folder


def ground_points(pixel_of, size):
    """Return points on the ground, m, and their pixels in an image."""
    axes = np.arange(-4, 4.1, 0.5), np.arange(-2, 9, 0.5)
    ground = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    pixel = pixel_of(np.column_stack([ground, np.zeros(len(ground))])[:, None])[:, 0]
    inside = ((pixel > 0) & (pixel < size)).all(axis=1)
    assert inside.sum() > 200
    return ground[inside], pixel[inside]


@pytest.mark.real_data
@pytest.mark.parametrize('pose', POSES)
@pytest.mark.parametrize('name', ['interactive.xml', 'key_dist_coeff.yml'])
def test_a_lens_under_another_name_is_read(files, name, pose):
    ground, pixel = ground_points(
        lambda world: cv2.projectPoints(world, RVEC, TVEC, MATRIX, LENS)[0], NARROW
    )
    mapping = read_calibration(files / name, NARROW, files / pose)
    np.testing.assert_allclose(mapping.ground_from_image(pixel), ground, rtol=0, atol=1e-6)


@pytest.mark.real_data
@pytest.mark.parametrize('pose', POSES)
@pytest.mark.parametrize(
    'name',
    ['ocv_fisheye.yml', 'melodic_skew0.yaml', 'melodic_skew.yaml', 'ros_fisheye.yaml',
     'topic_echo.yaml'],
)  # fmt: skip
def test_every_fisheye_is_read_as_one(files, name, pose):
    ground, pixel = ground_points(
        lambda world: cv2.fisheye.projectPoints(world, RVEC, TVEC, FISHEYE_MATRIX, FISHEYE)[0],
        WIDE,
    )
    camera = read_camera(files / name, WIDE, files / pose)
    assert camera.lens_residual_px < 0.25
    mapping = read_calibration(files / name, WIDE, files / pose)
    np.testing.assert_allclose(mapping.ground_from_image(pixel), ground, rtol=0, atol=0.03)
    skewed = name == 'melodic_skew.yaml'
    assert [each[:43] for each in camera.notes] == [
        'its skew of -0.966 moves pixels by 0.86 px '
    ] * skewed


@pytest.mark.real_data
@pytest.mark.parametrize(
    ('name', 'stated', 'size'),
    [('ocv_oldnames.yml', '820 x 616', WIDE), ('interactive.xml', '1280 x 720', WIDE)],
)
def test_a_size_under_another_name_is_held_against_the_images(files, name, stated, size):
    with pytest.raises(CalibrationError, match=f'{stated} px, not of 1640 x 1232 px'):
        read_calibration(files / name, size, files / 'tf.yaml')
