"""Kalibr's chains: each camera model against its equation, and which camera is meant."""

import cv2
import numpy as np
import pytest
import yaml

from mctrack_ros.ground import CalibrationError, Choice, read_calibration, stated_size
from written_cameras import LENSES, MATRIX, RVEC, SIZE, TVEC, check_seen, pose_yaml

INTRINSICS = [900.0, 905.0, 652.0, 341.0]
SQUARE = np.eye(4).tolist()


def camera(topic='/left/image_raw', **more):
    """Return one camera as Kalibr writes it."""
    return {
        'cam_overlaps': [1], 'camera_model': 'pinhole', 'distortion_model': 'radtan',
        'distortion_coeffs': LENSES['plumb_bob'][:4], 'intrinsics': INTRINSICS,
        'resolution': list(SIZE), 'rostopic': topic,
    } | more  # fmt: skip


FISHEYE = camera(
    '/right/image_raw', distortion_model='equidistant', distortion_coeffs=LENSES['equidistant'],
    T_cn_cnm1=SQUARE, T_cam_imu=SQUARE, timeshift_cam_imu=0.002,
)  # fmt: skip


@pytest.fixture
def read(tmp_path):
    """Return a function that writes a chain and reads a camera of it."""
    (tmp_path / 'pose.yml').write_text(pose_yaml())

    def calibration(chain, choice=Choice(), size=SIZE):  # noqa: B008
        path = tmp_path / 'camchain.yaml'
        path.write_text(chain if isinstance(chain, str) else yaml.safe_dump(chain))
        return read_calibration(path, size, tmp_path / 'pose.yml', choice=choice)

    return calibration


def test_a_chain_of_one_needs_no_choice(read, tmp_path):
    check_seen(read({'cam0': camera()}), terms=LENSES['plumb_bob'][:4])
    assert stated_size(tmp_path / 'camchain.yaml') == SIZE
    check_seen(read({'cam0': FISHEYE}), 'equidistant')
    check_seen(
        read({'cam0': camera(distortion_model='none', distortion_coeffs=[])}), terms=np.zeros(4)
    )
    text = '%YAML:1.0\n' + yaml.safe_dump({'cam0': FISHEYE})
    check_seen(read(text), 'equidistant')


@pytest.mark.parametrize(
    'choice',
    [Choice('cam1'), Choice('/right/image_raw'), Choice(topic='/right/image_raw'),
     Choice(topic='/right/image_raw/compressed'), Choice('cam1', '/left/image_raw')],
)  # fmt: skip
def test_one_of_several_is_chosen_by_its_key_or_topic(read, choice):
    check_seen(read({'cam0': camera(), 'cam1': FISHEYE}, choice), 'equidistant')


@pytest.mark.parametrize(
    ('choice', 'reason'),
    [
        (Choice(), r'several cameras, cam0 \(/left/image_raw\), cam1 \(/right/image_raw\): name'),
        (Choice(topic='image_raw/compressed'), 'several cameras, cam0'),
        (Choice('cam2'), r'no camera cam2, only cam0 \(/left/image_raw\), cam1'),
    ],
)
def test_a_camera_that_is_not_told_from_others_is_refused_with_a_list(read, choice, reason):
    with pytest.raises(CalibrationError, match=reason):
        read({'cam0': camera(), 'cam1': FISHEYE}, choice)


def test_its_resolution_is_held_against_the_images(read):
    with pytest.raises(CalibrationError, match='of 1280 x 720 px, not of 640 x 360 px'):
        read({'cam0': camera()}, size=(640, 360))


def directions(pixel_of):
    """Return points on the ground, m, and where a model puts them, inside the image."""
    axes = np.arange(-4, 4.1, 0.5), np.arange(-2, 9, 0.5)
    ground = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    world = np.column_stack([ground, np.zeros(len(ground))])
    pixel = pixel_of(world @ cv2.Rodrigues(RVEC)[0].T + TVEC)
    inside = ((pixel > 0) & (pixel < SIZE)).all(axis=1)
    assert inside.sum() > 50
    return ground[inside], pixel[inside]


def omni(point, xi, terms=()):
    """Return pixels by the omnidir model of OpenCV's contributed modules, its equations."""
    sphere = point / np.linalg.norm(point, axis=1, keepdims=True)
    plane = sphere[:, :2] / (sphere[:, 2:] + xi)
    k1, k2, p1, p2 = terms or (0, 0, 0, 0)
    (x, y), square = plane.T, (plane**2).sum(axis=1)
    radial = 1 + k1 * square + k2 * square**2
    u = x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x)
    v = y * radial + 2 * p2 * x * y + p1 * (square + 2 * y * y)
    return np.column_stack([u, v]) * [2000, 2010] + MATRIX[:2, 2]


def double_sphere(point, xi, alpha):
    x, y, z = point.T
    first = np.linalg.norm(point, axis=1)
    depth = xi * first + z
    second = np.sqrt(x * x + y * y + depth * depth)
    share = alpha * second + (1 - alpha) * depth
    return np.column_stack([x / share, y / share]) * [700, 705] + MATRIX[:2, 2]


def extended(point, alpha, beta):
    x, y, z = point.T
    share = alpha * np.sqrt(beta * (x * x + y * y) + z * z) + (1 - alpha) * z
    return np.column_stack([x / share, y / share]) * [900, 905] + MATRIX[:2, 2]


def field_of_view(point, width):
    plane = point[:, :2] / point[:, 2:]
    radius = np.linalg.norm(plane, axis=1, keepdims=True)
    shown = np.arctan(2 * radius * np.tan(width / 2)) / width
    return plane * shown / radius * INTRINSICS[:2] + MATRIX[:2, 2]


TANGENTIAL = (-0.1, 0.02, 5e-4, -3e-4)
MODELS = {
    'fov': (
        camera(distortion_model='fov', distortion_coeffs=[0.9]),
        lambda point: field_of_view(point, 0.9),
    ),
    'omni': (
        camera(camera_model='omni', intrinsics=[1.4, 2000.0, 2010.0, *INTRINSICS[2:]],
               distortion_model='none', distortion_coeffs=[]),
        lambda point: omni(point, 1.4),
    ),
    'omni-radtan': (
        camera(camera_model='omni', intrinsics=[1.4, 2000.0, 2010.0, *INTRINSICS[2:]],
               distortion_coeffs=list(TANGENTIAL)),
        lambda point: omni(point, 1.4, TANGENTIAL),
    ),
    'ds': (
        camera(camera_model='ds', intrinsics=[-0.2, 0.55, 700.0, 705.0, *INTRINSICS[2:]],
               distortion_model='none', distortion_coeffs=[]),
        lambda point: double_sphere(point, -0.2, 0.55),
    ),
    'eucm': (
        camera(camera_model='eucm', intrinsics=[0.6, 1.1, 900.0, 905.0, *INTRINSICS[2:]],
               distortion_model='none', distortion_coeffs=[]),
        lambda point: extended(point, 0.6, 1.1),
    ),
}  # fmt: skip


@pytest.mark.parametrize('model', MODELS)
def test_each_of_kalibrs_models_is_followed(read, model):
    stored, pixel_of = MODELS[model]
    ground, pixel = directions(pixel_of)
    found = read({'cam0': stored}).ground_from_image(pixel)
    np.testing.assert_allclose(found, ground, rtol=0, atol=5e-3 if 'radtan' in model else 1e-3)


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        ({'camera_model': 'ucm'}, "cam0: camera_model is 'ucm', expected one of"),
        ({'distortion_model': 'radtan8'}, "cam0: lens model is 'radtan8', expected one of"),
        ({'camera_model': 'ds', 'intrinsics': [0.1, 0.5, *INTRINSICS]},
         'ds with radtan, expected none'),
        ({'intrinsics': [1.0, *INTRINSICS]}, 'intrinsics holds 5 numbers, expected finite 4'),
        ({'distortion_coeffs': LENSES['plumb_bob']}, 'distortion_coeffs holds 5 numbers'),
        ({'resolution': [1280]}, 'resolution holds 1 numbers, expected finite 2'),
        ({'xi': 1.0}, 'cam0: xi: not known here'),
        ({'binning': 2}, 'cam0: binning: not known here'),
    ],
)  # fmt: skip
def test_what_kalibr_does_not_write_is_refused_by_name(read, change, reason):
    with pytest.raises(CalibrationError, match=reason):
        read({'cam0': camera(**change)})


@pytest.mark.parametrize(
    'key', ['camera_model', 'distortion_model', 'distortion_coeffs', 'resolution']
)
def test_what_a_camera_of_a_chain_lacks_is_named(read, key):
    chain = camera()
    del chain[key]
    with pytest.raises(CalibrationError, match=f'cam0: no {key}'):
        read({'cam0': chain})
