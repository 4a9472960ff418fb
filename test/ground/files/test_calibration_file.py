import dataclasses
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import yaml
from rosbags.typesys import Stores, get_typestore

from lens_cameras import SIZE, camera, seen_grid
from mctrack_ros.ground import (
    FORMATS,
    CalibrationError,
    ProjectiveMapping,
    StoredCamera,
    camera_from_info,
    file_format,
    mapping_from_grid,
    read_calibration,
    read_camera,
    read_grid,
    read_tsai,
    stated_size,
    stored_camera,
    write_calibration,
)

BENT = camera(distortion=(-0.2, 0.05, 1e-3, -5e-4, 0.01))
STRAIGHT = camera(distortion=(0, 0, 0, 0, 0))
POINTS = seen_grid(STRAIGHT)
ENDINGS = {
    'grid': 'xml', 'camera_info': 'yaml', 'opencv': 'xml', 'tsai': 'xml',
    'image_from_world': 'yaml', 'image_from_ground': 'yaml', 'ground_from_image': 'yaml',
}  # fmt: skip


def same(one, other, atol, heights=(0.0, 1.8)):
    for height in heights:
        np.testing.assert_allclose(
            one.image_from_ground(POINTS, height), other.image_from_ground(POINTS, height),
            rtol=0, atol=atol,
        )  # fmt: skip


@pytest.mark.parametrize(('to', 'ending'), [*ENDINGS.items(), ('opencv', 'yml')])
def test_a_straight_camera_survives_every_format(tmp_path, to, ending):
    path = tmp_path / f'camera.{ending}'
    assert write_calibration(STRAIGHT, path, to, 'cam1') < (1e-3 if to == 'grid' else 1e-6)
    same(read_calibration(path, SIZE), STRAIGHT, 1e-3 if to == 'grid' else 1e-6)
    assert stated_size(path) == (None if 'image' in to else SIZE)
    assert file_format(path) == ('projection' if 'image' in to else to)


@pytest.mark.parametrize(('to', 'ending'), [('camera_info', 'yaml'), ('opencv', 'yaml')])
def test_a_lens_survives_the_formats_that_hold_it(tmp_path, to, ending):
    path = tmp_path / f'camera.{ending}'
    write_calibration(BENT, path, to, 'cam1')
    same(read_calibration(path, SIZE), BENT, 1e-9)


def test_a_lens_is_sampled_into_a_grid(tmp_path):
    assert write_calibration(camera(), tmp_path / 'grid.xml', 'grid', 'cam1') < 0.01
    same(read_calibration(tmp_path / 'grid.xml', SIZE), camera(), 1e-3)


@pytest.mark.parametrize(
    'stored',
    [
        StoredCamera(np.array([600, 640, 350, 300.0]), np.zeros(5)),
        stored_camera(BENT),
    ],
)
def test_a_camera_that_its_grid_does_not_give_back_is_refused(tmp_path, stored):
    pose = stored_camera(STRAIGHT).pose
    mapping = dataclasses.replace(stored, pose=pose, image_size=SIZE).mapping(SIZE)
    with pytest.raises(CalibrationError, match=r'fitted to a grid .* misses .* px, .*opencv'):
        write_calibration(mapping, tmp_path / 'grid.xml', 'grid', 'cam1')
    assert not (tmp_path / 'grid.xml').exists()


@pytest.mark.parametrize('to', ['image_from_world', 'image_from_ground', 'ground_from_image'])
def test_a_lens_is_not_left_out_silently(tmp_path, to):
    with pytest.raises(CalibrationError, match=r'a matrix holds no lens.* px'):
        write_calibration(BENT, tmp_path / 'matrix.yaml', to, 'cam1')


def test_a_lens_that_tsai_has_no_term_for_is_refused(tmp_path):
    with pytest.raises(CalibrationError, match="Tsai's one radial term misses"):
        write_calibration(camera(distortion=(0, 0, 0.02, 0, 0)), tmp_path / 'a.xml', 'tsai', 'a')


@pytest.mark.parametrize('to', FORMATS)
def test_a_file_that_cannot_be_written_is_named(tmp_path, to):
    with pytest.raises(OSError, match='nowhere'):
        write_calibration(STRAIGHT, tmp_path / 'nowhere' / f'a.{ENDINGS[to]}', to, 'a')


def test_grid_cells_hold_no_camera(tmp_path):
    write_calibration(STRAIGHT, tmp_path / 'grid.xml', 'grid', 'cam1')
    cells = mapping_from_grid(read_grid(tmp_path / 'grid.xml'), SIZE, 'cell')
    with pytest.raises(CalibrationError, match='CellMapping has no camera'):
        write_calibration(cells, tmp_path / 'a.yaml', 'camera_info', 'a')


def test_a_mirrored_ground_is_seen_by_no_camera():
    matrix = STRAIGHT.camera.image_from_world.copy()
    matrix[:, 0] *= -1
    with pytest.raises(CalibrationError, match='mirrored'):
        stored_camera(ProjectiveMapping(matrix, SIZE))


def tsai_text(**changes):
    values = {
        'width': '720', 'height': '576', 'dpx': '0.005', 'dpy': '0.0046', 'focal': '5.5',
        'kappa1': '0.005', 'cx': '350', 'cy': '290', 'sx': '1.05', 'tx': '-938', 'ty': '-3357',
        'tz': '35370', 'rx': '2.0', 'ry': '-0.9', 'rz': '-0.4',
    } | changes  # fmt: skip
    groups = {
        'Geometry': ('width', 'height', 'dpx', 'dpy'),
        'Intrinsic': ('focal', 'kappa1', 'cx', 'cy', 'sx'),
        'Extrinsic': ('tx', 'ty', 'tz', 'rx', 'ry', 'rz'),
    }
    lines = [
        f'<{name} ' + ' '.join(f'{k}="{values[k]}"' for k in keys if values[k] is not None) + '/>'
        for name, keys in groups.items()
    ]
    return '\n'.join(['<Camera name="a">', *lines, '</Camera>'])


def test_tsai_undistorts_as_its_author_says_and_comes_back(tmp_path):
    path = tmp_path / 'tsai.xml'
    path.write_text(tsai_text())
    assert read_camera(path, SIZE).lens_residual_px < 0.01
    mapping = read_calibration(path, SIZE)
    pixel = np.array([[10.0, 570.0], [700.0, 300.0], [350.0, 500.0]])
    sensor = (pixel - [350, 290]) * [0.005 / 1.05, 0.0046]
    ideal = sensor * (1 + 0.005 * (sensor**2).sum(axis=1, keepdims=True)) / 5.5
    stored = read_tsai(path)
    ground = mapping.ground_from_image(pixel)
    world = np.column_stack([ground, np.zeros(3)]) @ stored.rotation.T + stored.translation
    np.testing.assert_allclose(world[:, :2] / world[:, 2:], ideal, atol=1e-5)
    write_calibration(mapping, tmp_path / 'again.xml', 'tsai', 'a')
    again = read_tsai(tmp_path / 'again.xml')
    kappa = again.kappa1 * again.focal_mm**2
    assert kappa == pytest.approx(stored.kappa1 * stored.focal_mm**2, rel=1e-3)


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        (tsai_text(kappa1=None), r':3: <Intrinsic> kappa1 is missing'),
        (tsai_text(tx='NaN'), r":4: <Extrinsic> tx is 'NaN', expected a finite number"),
        (tsai_text(focal='0'), 'expected above 0'),
        (tsai_text().replace(' kappa1', ' kappa2="0.1" kappa1'), '<Intrinsic>: kappa2: not known'),
        (tsai_text(kappa1='-0.2'), r'folds \d+% of the image over'),
        (tsai_text(tx='-93800', ty='-335700', tz='3537000'), r'camera would stand .*centimetres'),
        ('<Camera name="a"/>', 'has no <Geometry>'),
        ('<scene/>', 'a scene has no pixels'),
        ('<html/>', '<html> is no calibration'),
        ('<!DOCTYPE c [<!ENTITY e "e">]><Camera name="&e;"/>', 'entities are refused'),
        ('<!DOCTYPE c [<!ENTITY e SYSTEM "/etc/passwd">]><opencv_storage>&e;</opencv_storage>',
         'entities are refused'),
        ('<?xml version="1.0"?><opencv_storage></opencv_storage>', 'no camera_matrix'),
        ('<?xml version="1.0"?><opencv_storage><K>1 2</K></opencv_storage>', 'holds 2 numbers'),
        ('%YAML:1.0\n---\ncamera_matrix: wide\n', 'no matrix'),
        ('%YAML:1.0\n---\n{', 'not a readable YAML file'),
        ('lens: wide', 'no calibration that is known'),
        ('- 1', 'expected a mapping'),
        ('{', 'not a readable YAML file'),
        ('camera_matrix: 3', 'camera_matrix holds 1 numbers, expected finite 9'),
        ('', 'expected a mapping'),
    ],
)  # fmt: skip
def test_files_that_cannot_be_used_are_refused_by_name_and_reason(tmp_path, text, reason):
    path = tmp_path / 'camera.any'
    path.write_text(text)
    with pytest.raises(CalibrationError, match=reason) as refusal:
        read_calibration(path, SIZE)
    assert str(path) in str(refusal.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(CalibrationError, match=r'none.yaml: No such file'):
        read_calibration(tmp_path / 'none.yaml', SIZE)
    write_calibration(STRAIGHT, tmp_path / 'a.yaml', 'camera_info', 'a')
    with pytest.raises(CalibrationError, match=r'none.yaml: No such file'):
        read_calibration(tmp_path / 'a.yaml', SIZE, tmp_path / 'none.yaml')


@pytest.mark.parametrize('to', ['camera_info', 'opencv', 'tsai', 'grid'])
def test_a_calibration_for_another_image_size_is_refused(tmp_path, to):
    path = tmp_path / f'a.{ENDINGS[to]}'
    write_calibration(STRAIGHT, path, to, 'a')
    with pytest.raises(CalibrationError, match='720 x 576 px, not of 1440 x 1152 px'):
        read_calibration(path, (1440, 1152))


def info_with(tmp_path, **extrinsics):
    path = tmp_path / 'info.yaml'
    write_calibration(BENT, path, 'camera_info', 'cam1')
    content = yaml.safe_load(path.read_text())
    content['extrinsics'] = content['extrinsics'] | extrinsics
    path.write_text(yaml.safe_dump(content))
    return path, content


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        ({'translation': {'x': 1, 'y': 2}}, 'expected a translation of x, y, z'),
        ({'rotation': [0, 0, 0, 2]}, 'has not the length 1'),
        ({'rotation': [0, 0, 0, 1]}, 'see no ground.*optical frame'),
        ({'translation': [3.0, -30.0, -15.0]}, 'below the ground'),
        ({'translation': [3.0, -30.0, 1500.0]}, '1500 m above the ground.*centimetres'),
    ],
)
def test_poses_that_cannot_be_true_are_refused(tmp_path, change, reason):
    path, _ = info_with(tmp_path, **change)
    with pytest.raises(CalibrationError, match=reason):
        read_calibration(path, SIZE)


def test_a_pose_may_lie_in_a_file_of_its_own_as_tf_prints_it(tmp_path):
    path, content = info_with(tmp_path)
    pose = content.pop('extrinsics')
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(CalibrationError, match='name extrinsics'):
        read_calibration(path, SIZE)
    stamped = {'header': {'frame_id': 'map'}, 'child_frame_id': 'cam', 'transform': pose}
    (tmp_path / 'tf.yaml').write_text(yaml.safe_dump(stamped) + '---\n')
    same(read_calibration(path, SIZE, tmp_path / 'tf.yaml'), BENT, 1e-9)


def test_opencv_files_of_two_parts_in_centimetres_are_read(tmp_path):
    stored = stored_camera(BENT)
    across, down, x, y = stored.intrinsics
    rvec = cv2.Rodrigues(stored.pose.rotation)[0].ravel()
    tvec = stored.pose.translation * 100
    (tmp_path / 'in.xml').write_text(
        '<?xml version="1.0"?><opencv_storage><camera_matrix type_id="opencv-matrix">'
        f'<rows>3</rows><cols>3</cols><dt>d</dt><data>{across} 0 {x} 0 {down} {y} 0 0 1</data>'
        '</camera_matrix><distortion_coefficients type_id="opencv-matrix"><rows>5</rows>'
        f'<cols>1</cols><dt>d</dt><data>{" ".join(map(repr, stored.distortion.tolist()))}</data>'
        '</distortion_coefficients></opencv_storage>'
    )
    (tmp_path / 'out.xml').write_text(
        f'<?xml version="1.0"?><opencv_storage><rvec>{" ".join(map(repr, rvec.tolist()))}</rvec>'
        f'<tvec>{" ".join(map(repr, tvec.tolist()))}</tvec></opencv_storage>'
    )
    same(read_calibration(tmp_path / 'in.xml', SIZE, tmp_path / 'out.xml', 'cm'), BENT, 1e-6)
    with pytest.raises(CalibrationError, match=r'1500 m above the ground.*centimetres'):
        read_calibration(tmp_path / 'in.xml', SIZE, tmp_path / 'out.xml')


TERMS = {
    'plumb_bob': [-0.2, 0.05, 1e-3, -5e-4, 0.01],
    'rational_polynomial': [0.1, 0.02, 1e-4, -2e-4, 0.001, 0.3, 0.05, 0.002],
    'equidistant': [0.02, -0.01, 0.003, 0.0],
}


@pytest.mark.parametrize('model', TERMS)
def test_messages_are_read_with_every_lens_that_ros_knows(model):
    types = get_typestore(Stores.ROS2_JAZZY).types
    stored = stored_camera(BENT)
    across, down, x, y = stored.intrinsics
    matrix = np.array([[across, 0, x], [0, down, y], [0, 0, 1]])
    header = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](0, 0), 'cam')
    region = types['sensor_msgs/msg/RegionOfInterest'](0, 0, 0, 0, False)
    info = types['sensor_msgs/msg/CameraInfo'](
        header, SIZE[1], SIZE[0], model, np.array(TERMS[model]), matrix.ravel(), np.eye(3).ravel(),
        np.zeros(12), 0, 0, region,
    )  # fmt: skip
    place, turn = BENT.camera.position, stored.pose.rotation.T
    quaternion = cv2_quaternion(turn)
    transform = types['geometry_msgs/msg/Transform'](
        types['geometry_msgs/msg/Vector3'](*place),
        types['geometry_msgs/msg/Quaternion'](*quaternion),
    )
    stamped = types['geometry_msgs/msg/TransformStamped'](header, 'cam_optical_frame', transform)
    read = camera_from_info(info, stamped)
    mapping = read.mapping(SIZE)
    np.testing.assert_allclose(mapping.camera.position, place)
    points = np.column_stack([POINTS, np.zeros(len(POINTS))])[:, None]
    vector = cv2.Rodrigues(stored.pose.rotation)[0], stored.pose.translation
    if model == 'equidistant':
        pixel = cv2.fisheye.projectPoints(points, *vector, matrix, np.array(TERMS[model]))[0]
    else:
        pixel = cv2.projectPoints(points, *vector, matrix, np.array(TERMS[model]))[0]
    pixel = pixel[:, 0]
    inside = ((pixel > 0) & (pixel < SIZE)).all(axis=1)
    missed = np.abs(mapping.image_from_ground(POINTS)[inside] - pixel[inside]).max()
    assert missed <= read.lens_residual_px + 1e-6
    assert read.lens_residual_px < (0.1 if model == 'equidistant' else 1e-9)


def cv2_quaternion(rotation):
    vector = cv2.Rodrigues(rotation)[0].ravel()
    angle = np.linalg.norm(vector)
    return [*(np.sin(angle / 2) * vector / angle), np.cos(angle / 2)]


def test_an_unknown_lens_and_an_uncalibrated_camera_are_refused():
    matrix = [100.0, 0, 50, 0, 100, 50, 0, 0, 1]
    region = SimpleNamespace(x_offset=0, y_offset=0, width=0, height=0)
    info = SimpleNamespace(
        width=9, height=9, distortion_model='omnidirectional', d=[1], k=matrix, binning_x=0,
        binning_y=0, roi=region,
    )  # fmt: skip
    with pytest.raises(CalibrationError, match="'omnidirectional', expected one of"):
        camera_from_info(info)
    info.k = [0.0] * 9
    with pytest.raises(CalibrationError, match='not calibrated'):
        camera_from_info(info)
