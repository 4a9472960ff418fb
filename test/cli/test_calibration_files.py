"""Calibration files of other tools through the commands that take a site."""

import re

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from drawn_hall import SIZE as HALL_SIZE
from drawn_hall import write_hall
from mctrack_ros.cli.main import app
from mctrack_ros.ground import read_calibration, stored_camera
from written_cameras import LENSES, MATRIX, SIZE, opencv_yaml, pose_yaml, ros_yaml, seen

FISHEYE = np.array([LENSES['equidistant']]).T


def run(*arguments):
    return CliRunner().invoke(app, [str(each) for each in arguments])


@pytest.fixture
def check(tmp_path):
    """Return a function that writes a calibration and its site, and checks them."""
    (tmp_path / 'pose.yml').write_text(pose_yaml())

    def checked(content, size=SIZE, **more):
        (tmp_path / 'north.yml').write_text(
            content if isinstance(content, str) else yaml.safe_dump(content)
        )
        camera = {'calibration': 'north.yml', 'extrinsics': 'pose.yml'}
        camera |= {'image_width': size[0], 'image_height': size[1]} | more
        (tmp_path / 'site.yaml').write_text(yaml.safe_dump({'cameras': {'north': camera}}))
        return run('check-calibration', tmp_path / 'site.yaml')

    return checked


@pytest.mark.parametrize(
    'content',
    [
        opencv_yaml(cameraMatrix=MATRIX, dist_coeffs=np.zeros((1, 5)), cameraResolution=[*SIZE]),
        opencv_yaml(fisheye_model=1, camera_matrix=MATRIX, distortion_coefficients=FISHEYE),
        ros_yaml('fisheye', terms=LENSES['equidistant'], key='camera_model'),
    ],
)
def test_files_of_other_tools_can_be_used(check, content):
    result = check(content)
    assert result.exit_code == 0, result.exception
    assert 'north.yml can be used' in result.output
    assert 'skew' not in result.output


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        (opencv_yaml(camera_matrix=MATRIX), 'a camera matrix, but no distortion_coefficients'),
        (opencv_yaml(image_Width=820, image_Height=616, Camera_Matrix=MATRIX,
                     Distortion_Coefficients=np.zeros((5, 1))), '820 x 616 px, not of 1280 x 720'),
        (opencv_yaml(M1=MATRIX, D1=np.zeros((1, 5)), M2=MATRIX), r'several cameras \(M1, D1, M2'),
    ],
)  # fmt: skip
def test_what_a_file_states_and_cannot_be_used_ends_the_command(check, content, reason):
    result = check(content)
    assert result.exit_code == 1
    assert re.search(reason, str(result.exception))


def test_a_skew_that_is_left_out_is_said(check, tmp_path):
    skewed = MATRIX.copy()
    skewed[0, 1] = -0.966
    result = check(ros_yaml('fisheye', skewed, LENSES['equidistant']))
    assert result.exit_code == 0, result.exception
    said = 'its skew of -0.966 moves pixels by 0.22 px (RMS; at most 0.4 px): it is left out'
    assert said in result.output
    result = run('convert-calibration', tmp_path / 'north.yml', tmp_path / 'out.yaml',
                 '--extrinsics', tmp_path / 'pose.yml')  # fmt: skip
    assert result.exit_code == 0, result.exception
    assert said in result.output


def test_a_site_names_which_camera_of_a_chain_it_means(check, tmp_path):
    lenses = {'radtan': LENSES['plumb_bob'][:4], 'equidistant': LENSES['equidistant']}
    chain = {
        f'cam{index}': {
            'camera_model': 'pinhole', 'intrinsics': [900.0, 905.0, 652.0, 341.0],
            'distortion_model': model, 'distortion_coeffs': terms, 'resolution': [*SIZE],
            'rostopic': f'/hall/{index}/image_raw',
        }
        for index, (model, terms) in enumerate(lenses.items())
    }  # fmt: skip
    refused = check(chain)
    assert refused.exit_code == 1
    assert 'several cameras, cam0 (/hall/0/image_raw), cam1 (' in str(refused.exception)
    assert check(chain, calibration_camera='cam1').exit_code == 0
    assert check(chain, image_topic='/hall/1/image_raw').exit_code == 0
    result = run('convert-calibration', tmp_path / 'north.yml', tmp_path / 'out.yaml', '--topic',
                 '/hall/1/image_raw', '--extrinsics', tmp_path / 'pose.yml')  # fmt: skip
    assert result.exit_code == 0, result.exception
    ground, pixel = seen('equidistant')
    found = read_calibration(tmp_path / 'out.yaml', SIZE).ground_from_image(pixel)
    np.testing.assert_allclose(found, ground, rtol=0, atol=1e-3)


def test_a_camera_asked_for_in_a_file_of_one_is_refused(check):
    result = check(ros_yaml(), calibration_camera='cam1')
    assert 'it holds one camera alone, no cam1' in str(result.exception)


def positions(folder):
    """Return frames and positions of a tracked bag's `tracks.txt`."""
    return np.loadtxt(folder / 'tracks.txt', delimiter=',')


@pytest.mark.xdist_group('replay')
def test_tracks_are_the_same_whoever_wrote_the_calibration(tmp_path):
    bag, site = write_hall(tmp_path, seconds=4.0)
    assert run('track', bag, '--out', tmp_path / 'matrices', '--site', tmp_path / 'site.yaml')
    stored = {name: stored_camera(camera.mapping()) for name, camera in site.cameras.items()}
    across, down, x, y = stored['north'].intrinsics.tolist()
    matrix = np.array([[across, 0, x], [0, down, y], [0, 0, 1]])
    for name, camera in stored.items():
        pose = {'R': camera.pose.rotation, 'tvec': camera.pose.translation[:, None]}
        (tmp_path / f'{name}_pose.yml').write_text(opencv_yaml(**pose))
    (tmp_path / 'north.yml').write_text(
        opencv_yaml(
            cameraMatrix=matrix, dist_coeffs=np.zeros((1, 5)), cameraResolution=[*HALL_SIZE]
        )
    )
    across, down, x, y = stored['south'].intrinsics.tolist()
    info = {
        'width': HALL_SIZE[0], 'height': HALL_SIZE[1], 'distortion_model': 'plumb_bob',
        'd': [0.0] * 5, 'k': [across, 0.2, x, 0, down, y, 0, 0, 1],
        'r': [0.0] * 9, 'p': [0.0] * 12,
    }  # fmt: skip
    (tmp_path / 'south.yml').write_text(yaml.safe_dump(info) + '---\n')
    cameras = {
        name: {'calibration': f'{name}.yml', 'extrinsics': f'{name}_pose.yml',
               'image_width': HALL_SIZE[0], 'image_height': HALL_SIZE[1]}
        for name in stored
    }  # fmt: skip
    (tmp_path / 'other.yaml').write_text(yaml.safe_dump({'name': 'hall', 'cameras': cameras}))
    result = run('track', bag, '--out', tmp_path / 'files', '--site', tmp_path / 'other.yaml')
    assert result.exit_code == 0, result.exception
    assert 'south.yml: its skew of 0.2 moves pixels by 0.042 px' in result.stderr
    ours, theirs = positions(tmp_path / 'matrices'), positions(tmp_path / 'files')
    assert len(ours) > 50
    np.testing.assert_allclose(theirs[:, :4], ours[:, :4], atol=0.01)
