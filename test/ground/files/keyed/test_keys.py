"""Cameras from files of OpenCV, ROS and scripts: every spelling is read, or refused by name."""

import cv2
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from mctrack_ros.cli.main import app
from mctrack_ros.ground import (
    CalibrationError,
    read_calibration,
    read_camera,
    read_extrinsics,
    stated_size,
)
from written_cameras import (
    LENSES,
    MATRIX,
    RVEC,
    SIZE,
    TVEC,
    check_seen,
    opencv_yaml,
    pose_yaml,
    ros_yaml,
    tf_pose,
)

PLUMB_BOB = np.array([LENSES['plumb_bob']])
FISHEYE = np.array([LENSES['equidistant']]).T


@pytest.fixture
def read(tmp_path):
    """Return a function that writes a file and reads it, with the pose in another."""
    pose = tmp_path / 'pose.yml'
    pose.write_text(pose_yaml())

    def calibration(content, size=SIZE, extrinsics=pose):
        path = tmp_path / 'camera.yml'
        path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
        return read_calibration(path, size, extrinsics)

    return calibration


SAMPLE = {
    'calibration_time': '"Thu 26 Nov 2026"', 'nframes': 20, 'board_width': 9, 'board_height': 6,
    'square_size': 0.025, 'aspectRatio': 1.0, 'flags': 2, 'avg_reprojection_error': 0.3,
    'per_view_reprojection_errors': np.ones((20, 1)), 'extrinsic_parameters': np.ones((20, 6)),
    'image_points': np.ones((20, 54)), 'grid_points': np.ones((54, 3)),
}  # fmt: skip
"""What OpenCV's sample writes beside the camera; none of it says where images show things."""
SPELLED = {
    'calibration.cpp': {
        'image_width': SIZE[0], 'image_height': SIZE[1], 'camera_matrix': MATRIX,
        'distortion_coefficients': PLUMB_BOB.T,
    },
    'the sample of OpenCV 2': {
        'nrOfFrames': 20, 'image_Width': SIZE[0], 'image_Height': SIZE[1], 'board_Width': 9,
        'FixAspectRatio': 1, 'flagValue': 14, 'Camera_Matrix': MATRIX,
        'Distortion_Coefficients': PLUMB_BOB.T, 'Avg_Reprojection_Error': 0.3,
        'Per_View_Reprojection_Errors': np.ones((3, 1)), 'Extrinsic_Parameters': np.ones((3, 6)),
    },
    'interactive calibration': {
        'calibrationDate': '"Thu"', 'framesCount': 34, 'cameraResolution': str(list(SIZE)),
        'cameraMatrix': MATRIX, 'cameraMatrix_std_dev': np.ones((4, 1)),
        'dist_coeffs': PLUMB_BOB, 'dist_coeffs_std_dev': np.zeros((5, 1)),
        'avg_reprojection_error': 0.31,
    },
    'ArUco': {'image_width': SIZE[0], 'image_height': SIZE[1], 'fisheye_model': 0,
              'camera_matrix': MATRIX, 'distortion_coefficients': PLUMB_BOB},
    'scripts': {'camera_matrix': MATRIX, 'dist_coeff': PLUMB_BOB},
    'more scripts': {'mtx': MATRIX, 'dist': PLUMB_BOB, 'rms': 0.4},
    'short ones': {'K': MATRIX, 'D': PLUMB_BOB, 'image_size': str(list(SIZE))},
    'intrinsics': {'intrinsic_matrix': MATRIX, 'distCoeffs': PLUMB_BOB},
}  # fmt: skip


@pytest.mark.parametrize('tool', SPELLED)
def test_every_spelling_of_a_matrix_and_a_lens_is_read(read, tool):
    check_seen(read(opencv_yaml(**SPELLED[tool])))


def test_what_says_nothing_of_the_camera_is_let_pass(read):
    check_seen(read(opencv_yaml(**SAMPLE, **SPELLED['calibration.cpp'])))
    more = {'camera_name': 'fisheye_left', 'mean_error': 0.1, 'created': '"Thu"', 'fps': 25.0}
    check_seen(read(opencv_yaml(**more, **SPELLED['calibration.cpp'])))


@pytest.mark.parametrize(
    'tool', ['calibration.cpp', 'the sample of OpenCV 2', 'interactive calibration', 'short ones']
)
def test_every_spelling_of_the_images_size_is_held_against_them(read, tool):
    with pytest.raises(CalibrationError, match='of 1280 x 720 px, not of 640 x 360 px'):
        read(opencv_yaml(**SPELLED[tool]), (640, 360))


@pytest.mark.parametrize('type_id', ['opencv-matrix', 'opencv-nd-matrix'])
def test_the_xml_of_interactive_calibration_is_read(read, type_id):
    def matrix(name, values, shape):
        data = ' '.join(map(repr, np.ravel(values).tolist()))
        return f'<{name} type_id="{type_id}">{shape}<dt>d</dt><data>{data}</data></{name}>'

    lens = matrix('dist_coeffs', PLUMB_BOB, '<rows>1</rows><cols>5</cols>')
    size = matrix('cameraResolution', SIZE, '<sizes>2</sizes>')
    camera = matrix('cameraMatrix', MATRIX, '<rows>3</rows><cols>3</cols>')
    text = f'<?xml version="1.0"?><opencv_storage>{size}{camera}{lens}</opencv_storage>'
    check_seen(read(text))
    with pytest.raises(CalibrationError, match='of 1280 x 720 px, not of 640 x 360 px'):
        read(text, (640, 360))


def test_what_opencv_writes_itself_is_read_in_all_its_formats(read, tmp_path):
    for ending in ('xml', 'yml', 'json'):
        storage = cv2.FileStorage(str(tmp_path / f'a.{ending}'), cv2.FILE_STORAGE_WRITE)
        storage.write('cameraMatrix', MATRIX)
        storage.write('distCoeffs', PLUMB_BOB)
        storage.release()
        check_seen(read((tmp_path / f'a.{ending}').read_text()))


def test_scripts_that_dump_plain_lists_are_read(read):
    rows = {'camera_matrix': MATRIX.tolist(), 'dist_coeff': PLUMB_BOB.tolist()}
    check_seen(read(rows))
    check_seen(read(rows | {'rvec': RVEC.tolist(), 'tvec': TVEC.tolist()}, extrinsics=''))


@pytest.mark.parametrize(
    'said',
    [{'fisheye_model': 1}, {'fisheye': 'true'}, {'camera_model': 'fisheye'},
     {'distortion_model': 'equidistant'}, {'distortion_model': 'kannala_brandt'},
     {'camera_model': 'pinhole', 'distortion_model': '"Kannala-Brandt4"'},
     {'model': '"pinhole"', 'distortion_model': 'fisheye', 'fisheye_model': 1}],
    ids=str,
)  # fmt: skip
def test_every_name_of_a_fisheye_is_read_as_one(read, said):
    text = opencv_yaml(**said, camera_matrix=MATRIX, distortion_coefficients=FISHEYE)
    check_seen(read(text), 'equidistant')


def test_a_fisheye_of_which_only_a_comment_tells_is_read_as_one(read):
    text = opencv_yaml(flags=10, camera_matrix=MATRIX, distortion_coefficients=FISHEYE)
    comment = '# flags: +fix_skew +recompute_extrinsic\nflags'
    check_seen(read(text.replace('flags', comment)), 'equidistant')


@pytest.mark.parametrize('model', LENSES)
def test_the_yaml_of_camera_calibration_is_read_with_each_of_its_lenses(read, model):
    check_seen(read(ros_yaml(model)), model)


@pytest.mark.parametrize('key', ['distortion_model', 'camera_model'])
def test_a_fisheye_of_ros_is_read_by_either_name(read, key):
    terms = LENSES['equidistant']
    content = ros_yaml('fisheye', terms=terms, key=key)
    check_seen(read(content), 'equidistant')


def test_a_small_skew_is_left_out_and_said(tmp_path, read):
    skewed = MATRIX.copy()
    skewed[0, 1] = -0.7
    check_seen(read(ros_yaml('equidistant', skewed)), 'equidistant')
    (note,) = read_camera(tmp_path / 'camera.yml', SIZE).notes
    assert note == (
        'its skew of -0.7 moves pixels by 0.16 px (RMS; at most 0.29 px): it is left out'
    )
    skewed[0, 1] = -7.0
    with pytest.raises(CalibrationError, match=r'skew of -7 moves pixels by 1.6 px .* below 1 px'):
        read(ros_yaml('equidistant', skewed))


THIN = [-0.2, 0.05, 1e-3, -5e-4, 0.01, 0.1, 0.02, 0.0, 1e-3, -5e-4, 8e-4, 2e-4]
TILTED = [*THIN[:8], 0, 0, 0, 0, 0.002, -0.003]


@pytest.mark.parametrize('terms', [THIN, TILTED])
def test_thin_prisms_and_tilted_sensors_are_followed_within_a_pixel(tmp_path, read, terms):
    mapping = read(ros_yaml('rational_polynomial', terms=terms))
    missed = read_camera(tmp_path / 'camera.yml', SIZE).lens_residual_px
    assert 0 < missed < 1
    check_seen(mapping, 'rational_polynomial', terms=terms, atol=0.01)


def test_a_tilt_that_no_lens_follows_is_refused(read):
    with pytest.raises(CalibrationError, match=r'does not follow this one: .* px off'):
        read(ros_yaml('rational_polynomial', terms=[*THIN[:8], 0, 0, 0, 0, 0.2, -0.3]))


def message(**more):
    """Return a printed `CameraInfo`."""
    stamp = {'sec': 1759842258, 'nanosec': 831630048}
    region = dict.fromkeys(('x_offset', 'y_offset', 'height', 'width'), 0) | {'do_rectify': False}
    return {
        'header': {'stamp': stamp, 'frame_id': 'cam_optical'}, 'height': SIZE[1], 'width': SIZE[0],
        'distortion_model': 'plumb_bob', 'd': LENSES['plumb_bob'], 'k': MATRIX.ravel().tolist(),
        'r': np.eye(3).ravel().tolist(), 'p': [0.0] * 12, 'binning_x': 0, 'binning_y': 0,
        'roi': region,
    } | more  # fmt: skip


def test_printed_messages_are_read(read):
    check_seen(read(message()))
    check_seen(read(yaml.safe_dump(message()) + '---\n'))
    later = message(header={'stamp': {'sec': 5, 'nanosec': 0}, 'frame_id': 'cam_optical'})
    check_seen(read(yaml.safe_dump_all([message(), later]) + '---\n'))
    first = {key.upper() if len(key) == 1 else key: value for key, value in message().items()}
    check_seen(read(first | {'header': {'seq': 7, 'frame_id': 'cam_optical'}}))
    fisheye = message(distortion_model='equidistant', d=LENSES['equidistant'])
    check_seen(read(fisheye), 'equidistant')


def test_printed_messages_that_differ_are_refused(read):
    zoomed = message(k=(MATRIX * [[2], [2], [1]]).ravel().tolist())
    with pytest.raises(CalibrationError, match='several messages that differ: keep one'):
        read(yaml.safe_dump_all([message(), zoomed]))


@pytest.mark.parametrize(
    ('key', 'printed'),
    [
        ('k', [*MATRIX.ravel().tolist()[:4], '...']),
        ('d', [*LENSES['plumb_bob'][:3], '...']),
        ('k', '<array type: double[9]>'),
        ('d', '<sequence type: double, length: 5>'),
        ('distortion_model', 'plum...'),
        ('distortion_model', '<string length: <9>>'),
    ],
)
def test_a_message_that_is_printed_in_part_is_to_be_printed_whole(tmp_path, key, printed):
    path = tmp_path / 'info.yaml'
    path.write_text(yaml.safe_dump(message(**{key: printed})) + '---\n')
    command = ['convert-calibration', str(path), str(tmp_path / 'out.yaml')]
    told = str(CliRunner().invoke(app, command).exception)
    assert f'info.yaml: {key} is not printed whole: print it again by `ros2 topic echo' in told
    assert '--full-length' in told
    assert '\n' not in told


@pytest.mark.parametrize('make', [message, ros_yaml])
def test_binning_and_a_region_of_interest_are_used(tmp_path, read, make):
    region = {'x_offset': 200, 'y_offset': 100, 'width': 800, 'height': 600}
    content = make(binning_x=2, binning_y=4, roi=region)
    binned = MATRIX.copy()
    binned[:2, 2] -= 200, 100
    binned[0] /= 2
    binned[1] /= 4
    check_seen(read(content, (400, 150)), matrix=binned, size=(400, 150), atol=1e-2)
    assert stated_size(tmp_path / 'camera.yml') == (400, 150)
    with pytest.raises(CalibrationError, match='of 400 x 150 px, not of 1280 x 720 px'):
        read(content)


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        (
            {'roi': {'x_offset': 900, 'width': 600, 'height': 600}},
            'roi reaches out of the image',
        ),
        ({'binning_x': 2000}, 'binning by 2000 x 1 leaves no pixel'),
        ({'binning_y': -1}, 'binning_y is -1, expected a whole number'),
        ({'width': 10**30}, 'width is 1000.*, expected a whole number up to 1000000'),
        ({'roi': [0, 0, 640, 480]}, r'roi is \[0, 0, 640, 480\], expected a mapping'),
        ({'d': [10**400, 0, 0, 0, 0]}, 'd is no matrix, or holds more than numbers'),
    ],
)
def test_a_part_of_the_sensor_that_cannot_be_is_refused(read, change, reason):
    with pytest.raises(CalibrationError, match=reason):
        read(message(**change))


BARE = {'camera_matrix': MATRIX, 'distortion_coefficients': PLUMB_BOB}
REFUSED = {
    'no lens': ({'camera_matrix': MATRIX}, 'a camera matrix, but no distortion_coefficients'),
    'an empty lens': (
        {'camera_matrix': MATRIX, 'dist': '[]'}, 'a camera matrix, but no distortion_coefficients'
    ),
    'an unknown lens key': (
        {'camera_matrix': MATRIX, 'lens_terms': PLUMB_BOB}, 'no distortion|lens_terms'
    ),
    'one more lens key': (BARE | {'distortion_k4': 0.1}, 'distortion_k4: not known here'),
    'xi': (BARE | {'xi': 1.2}, 'xi: not known here'),
    'alpha': (BARE | {'alpha': 0.5}, 'alpha: not known here'),
    'a lens term of its own': (BARE | {'k4': 0.1}, 'k4: not known here'),
    'an unknown size': (BARE | {'sensor_width': 640}, 'sensor_width: not known here'),
    'rows and columns': (BARE | {'rows': 360, 'cols': 640}, 'rows, cols: not known here'),
    'a size below a key': (BARE | {'image': '{ width: 640 }'}, 'image: not known here'),
    'a lens under any key': (BARE | {'type': 'fisheye'}, 'type: not known here'),
    'a projection that is a name': (BARE | {'projection': 'Omni'}, 'projection: not known here'),
    'an offset': (BARE | {'OffsetX': 320}, 'OffsetX: not known here'),
    'a crop': (BARE | {'crop': '[ 0, 0, 640, 360 ]'}, 'crop: not known here'),
    'binning without a size': (BARE | {'binning_x': 2}, 'binning, but no image_width'),
    'a width alone': (BARE | {'image_width': 1280}, 'image_width alone'),
    'two sizes': (
        BARE | {'image_width': 1280, 'image_height': 720, 'imageSize': '[ 640, 360 ]'},
        'two sizes of images',
    ),
    'two lenses': (BARE | {'D': np.zeros((1, 5))}, 'distortion_coefficients and D differ'),
    'two models': (
        BARE | {'fisheye_model': 1, 'distortion_model': 'plumb_bob'}, 'two lens models'
    ),
    'no fisheye and one': (
        BARE | {'fisheye_model': 0, 'distortion_model': 'equidistant'}, 'two lens models'
    ),
    'an unknown model': (BARE | {'camera_model': 'omni'}, "lens model is 'omni', expected one of"),
    'an inverse lens': (
        BARE | {'distortion_model': 'inverse_brown_conrady'}, "lens model is 'inverse_brown_conr"
    ),
    'no model, but terms': (BARE | {'distortion_model': 'none'}, 'no lens model, but 5 terms'),
    'four terms without a model': (
        {'K': MATRIX, 'D': FISHEYE}, 'say which, as distortion_model: equidistant'
    ),
    'too many terms': (
        BARE | {'distortion_model': 'plumb_bob', 'distortion_coefficients': np.ones((1, 8))},
        '8 terms, expected at most 5',
    ),
    'stereo intrinsics': (
        {'M1': MATRIX, 'D1': PLUMB_BOB, 'M2': MATRIX, 'D2': PLUMB_BOB}, 'cameras .M1, D1, M2, D2'
    ),
    'a pair': (
        {'cameraMatrix1': MATRIX, 'distCoeffs1': PLUMB_BOB, 'cameraMatrix2': MATRIX},
        'several cameras .cameraMatrix1, distCoeffs1, cameraMatrix2',
    ),
    'left and right': (
        {'K_left': MATRIX, 'D_left': PLUMB_BOB, 'K_right': MATRIX}, 'cameras .K_left, D_left, K_r'
    ),
    'one and another': (BARE | {'K2': MATRIX}, 'several cameras .K2'),
    'a rotation alone': (BARE | {'rvec': RVEC[:, None]}, 'rvec alone is no pose'),
    'two rotations': (
        BARE | {'rvec': RVEC[:, None], 'R': np.eye(3), 'tvec': TVEC[:, None]}, 'rvec and R differ'
    ),
    'another matrix': (BARE | {'camera_matrix': np.eye(3)[::-1]}, 'the camera matrix is'),
}  # fmt: skip


@pytest.mark.parametrize('case', REFUSED)
def test_what_is_stated_and_not_used_is_refused_by_name(read, case):
    content, reason = REFUSED[case]
    with pytest.raises(CalibrationError, match=reason) as refusal:
        read(opencv_yaml(**content))
    assert 'camera.yml: ' in str(refusal.value)
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize('head', ['%YAML:1.0\n---\n', ''])
def test_a_key_that_stands_twice_is_refused(read, head):
    once = (
        opencv_yaml(**BARE).removeprefix('%YAML:1.0\n---\n')
        if head
        else yaml.safe_dump({'K': MATRIX.tolist(), 'D': PLUMB_BOB.tolist()})
    )
    with pytest.raises(CalibrationError, match='stands twice in it'):
        read(head + once + once)


def test_a_pair_is_named_in_plain_yaml_too(read):
    with pytest.raises(CalibrationError, match=r'several cameras \(D1, D2, K1, K2\)'):
        read({name: MATRIX.tolist() for name in ('K1', 'D1', 'K2', 'D2')})


def test_a_shape_that_its_numbers_do_not_fill_is_refused(read):
    content = ros_yaml()
    content['distortion_coefficients']['cols'] = 8
    with pytest.raises(CalibrationError, match='holds 5 numbers, expected finite 8'):
        read(content)


def test_a_camera_without_a_lens_says_so(read):
    straight = ros_yaml('none', terms=[])
    check_seen(read(straight), terms=np.zeros(5))
    zeros = {'camera_matrix': MATRIX, 'distortion_coefficients': np.zeros((1, 5))}
    check_seen(read(opencv_yaml(**zeros)), terms=np.zeros(5))


POSES = {
    'OpenCV': pose_yaml(),
    'matrices': opencv_yaml(R=cv2.Rodrigues(RVEC)[0], T=TVEC[:, None]),
    'both': opencv_yaml(R=cv2.Rodrigues(RVEC)[0], rvec=RVEC[:, None], tvec=TVEC[:, None]),
    'a script': yaml.safe_dump({'rvec': RVEC.tolist(), 'tvec': TVEC.tolist()}),
    'XML': (
        '<?xml version="1.0"?><opencv_storage>'
        f'<rvec>{" ".join(map(repr, RVEC.tolist()))}</rvec>'
        f'<tvec>{" ".join(map(repr, TVEC.tolist()))}</tvec></opencv_storage>'
    ),
}
PLACE, TURN = tf_pose()
NAMED = {'translation': dict(zip('xyz', PLACE)), 'rotation': dict(zip('xyzw', TURN))}
STAMPED = {
    'header': {'stamp': {'sec': 1, 'nanosec': 0}, 'frame_id': 'map'},
    'child_frame_id': 'cam_optical',
    'transform': NAMED,
}
POSES |= {
    'TF': yaml.safe_dump(NAMED),
    'lists': yaml.safe_dump({'translation': PLACE, 'rotation': TURN}),
    'a pose': yaml.safe_dump({'pose': {'position': PLACE, 'orientation': TURN}}),
    'a stamped transform': yaml.safe_dump(STAMPED) + '---\n',
    'a TFMessage': yaml.safe_dump({'transforms': [STAMPED]}) + '---\n',
    'tf2_echo': (
        f'At time 0.0\n- Translation: {PLACE}\n- Rotation: in Quaternion (xyzw) {TURN}\n'
        '- Rotation: in RPY (radian) [1.0, 2.0, 3.0]\n- Matrix:\n  1.0 0.0 0.0 0.0\n'
    ),
    'an older tf_echo': (
        f'At time 0.0\n- Translation: {PLACE}\n- Rotation: in Quaternion {TURN}\n'
        '            in RPY (radian) [1.0, 2.0, 3.0]\n'
    ),
}


@pytest.mark.parametrize('tool', POSES)
def test_every_way_to_write_a_pose_is_read(read, tmp_path, tool):
    path = tmp_path / 'own_pose.txt'
    path.write_text(POSES[tool])
    check_seen(read(opencv_yaml(**BARE), extrinsics=path))


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        (opencv_yaml(tvec=TVEC[:, None]), 'tvec alone is no pose'),
        (opencv_yaml(rvec=RVEC[:2, None], tvec=TVEC[:, None]), 'rvec holds 2 numbers, expected'),
        (opencv_yaml(R=np.eye(3), T=TVEC[:, None], R1=np.eye(3), P1=np.eye(3), Q=np.eye(4)),
         'several cameras .R1, P1, Q'),
        (opencv_yaml(flags=1), 'no pose: expected a translation'),
        (yaml.safe_dump(NAMED | {'units': 'mm'}), 'units: not known here'),
        (yaml.safe_dump(NAMED | {'rvec': [0, 0, 0], 'tvec': [0, 0, 0]}), '2 poses: keep one'),
        (yaml.safe_dump({'translation': PLACE, 'rotation': [1.0, 0.0, 0.0]}),
         'a rotation of x, y, z, w'),
        (yaml.safe_dump({'translation': PLACE, 'rotation_rpy': [0, 0, 0]}),
         'rotation_rpy: not known here'),
        (yaml.safe_dump(STAMPED | {'header': {'frame_id': 'cam_optical'},
                                   'child_frame_id': 'map'}), 'it is of map in cam_optical'),
        (yaml.safe_dump({'transforms': [STAMPED, STAMPED]}), 'transforms: expected one alone'),
        (yaml.safe_dump({'extrinsics': PLACE}), 'expected translation and rotation'),
        (f'- Translation: {PLACE}\n- Rotation: in Quaternion {TURN}\n'
         f'- Translation: [1, 2, 3]\n- Rotation: in Quaternion {TURN}\n', 'that differ: keep one'),
    ],
)  # fmt: skip
def test_poses_that_are_none_or_ambiguous_are_refused_by_name(tmp_path, text, reason):
    path = tmp_path / 'pose.txt'
    path.write_text(text)
    with pytest.raises(CalibrationError, match=reason) as refusal:
        read_extrinsics(path)
    assert 'pose.txt: ' in str(refusal.value)


@pytest.mark.parametrize(
    ('x', 'is_said'), [(320.0, False), (40.0, False), (640.0, True), (871.2, True)]
)
def test_a_principal_point_outside_the_images_is_said(tmp_path, x, is_said):
    path = tmp_path / 'camera.yaml'
    path.write_text(
        'image_width: 640\nimage_height: 480\ndistortion_model: plumb_bob\n'
        f'camera_matrix: {{rows: 3, cols: 3, data: [600, 0, {x}, 0, 600, 240, 0, 0, 1]}}\n'
        'distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n'
    )
    notes = read_camera(path, (640, 480)).notes
    assert len(notes) == is_said
    assert all('lies outside its images of 640 x 480 px' in note for note in notes)
