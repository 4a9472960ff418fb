"""The old text format of ROS's `camera_calibration`."""

import numpy as np
import pytest

from mctrack_ros.ground import CalibrationError, Choice, read_calibration, stated_size
from written_cameras import LENSES, MATRIX, SIZE, check_seen, pose_yaml


def rows(values):
    return '\n'.join(' '.join(f'{each:8f}' for each in row) for row in np.atleast_2d(values))


def section(name='narrow_stereo/left', lens=LENSES['plumb_bob']):
    return (
        f'[{name}]\n\ncamera matrix\n{rows(MATRIX)}\n\ndistortion\n{rows(lens)}\n\n'
        f'rectification\n{rows(np.eye(3))}\n\nprojection\n{rows(np.eye(3, 4))}\n'
    )


HEAD = f'# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n{SIZE[0]}\n\nheight\n{SIZE[1]}\n\n'
EXTERNALS = '[externals]\n\ntranslation\n{}\n\nrotation\n0 0 0\n\n'


@pytest.fixture
def read(tmp_path):
    (tmp_path / 'pose.yml').write_text(pose_yaml())

    def calibration(text, choice=Choice(), size=SIZE):  # noqa: B008
        (tmp_path / 'ost.txt').write_text(text)
        return read_calibration(tmp_path / 'ost.txt', size, tmp_path / 'pose.yml', choice=choice)

    return calibration


@pytest.mark.parametrize('model', ['plumb_bob', 'rational_polynomial'])
def test_a_camera_is_read(read, tmp_path, model):
    check_seen(read(HEAD + section(lens=LENSES[model])), model)
    assert stated_size(tmp_path / 'ost.txt') == SIZE
    check_seen(read(HEAD + EXTERNALS.format('0 0 0') + section(lens=LENSES[model])), model)


def test_one_of_a_pair_is_chosen_by_its_name(read):
    pair = HEAD + section() + section('narrow_stereo/right', LENSES['rational_polynomial'])
    check_seen(read(pair, Choice('narrow_stereo/right')), 'rational_polynomial')
    with pytest.raises(CalibrationError, match='cameras, narrow_stereo/left, narrow_stereo/right'):
        read(pair)


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        (HEAD + section(lens=LENSES['equidistant']), 'four lens terms can be of a fisheye or not'),
        (HEAD + EXTERNALS.format('0.1 0 0') + section(), r'\[externals\] are of a camera to anot'),
        (HEAD, 'no section of a camera'),
        (HEAD + section().replace('distortion', 'lens'), 'lens: not known here'),
        (HEAD + section(lens=[]), 'but no distortion_coefficients'),
        (HEAD.replace('[image]', '[image]\n3 4'), ':5: numbers without a heading'),
        (HEAD + section().replace('652.0', '652,0'), "652,0.*expected numbers"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused_by_name(read, text, reason):
    with pytest.raises(CalibrationError, match=reason) as refusal:
        read(text)
    assert 'ost.txt' in str(refusal.value)


def test_its_size_is_held_against_the_images(read):
    with pytest.raises(CalibrationError, match='of 1280 x 720 px, not of 640 x 360 px'):
        read(HEAD + section(), size=(640, 360))
