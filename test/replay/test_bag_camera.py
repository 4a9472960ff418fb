"""A camera's calibration out of a bag."""

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore
from typer.testing import CliRunner

from mctrack_ros.cli.main import app
from mctrack_ros.ground import CalibrationError, HeardCamera, read_calibration
from mctrack_ros.recording import BagError, BagWriter
from mctrack_ros.replay.bag_camera import camera_from_bag
from ros_cameras import (
    DOWN_TURN,
    HOUSE,
    HOUSE_TURN,
    POLE,
    camera_info,
    house_place,
    transforms,
)

kinds = get_typestore(Stores.ROS2_JAZZY).types.__getitem__
TOPIC = '/north/camera_info'
STATIC = transforms(kinds, ('map', 'house', HOUSE, HOUSE_TURN))
MOVING = transforms(kinds, ('house', 'north_optical_frame', POLE, DOWN_TURN))


def bag(path, *messages):
    """Write a bag of (topic, message)."""
    with BagWriter(path) as writer:
        for index, (topic, message) in enumerate(messages):
            writer.write(topic, message, 1000 + index)
    return path


@pytest.fixture
def whole(tmp_path):
    info, _ = camera_info(kinds)
    return bag(tmp_path / 'bag', (TOPIC, info), ('/tf_static', STATIC), ('/tf', MOVING))


def run(*arguments):
    return CliRunner().invoke(app, [str(each) for each in arguments])


def test_a_bag_is_converted_with_static_and_moving_transforms_chained(whole, tmp_path):
    result = run('convert-calibration', whole, tmp_path / 'north.yaml')
    assert result.exit_code == 0, result.exception
    assert 'camera_info, for images of 720 x 576 px' in result.output
    _, stored = camera_info(kinds)
    read = read_calibration(tmp_path / 'north.yaml', stored.image_size).camera
    np.testing.assert_allclose(read.intrinsics, stored.intrinsics)
    np.testing.assert_allclose(read.distortion, stored.distortion)
    np.testing.assert_allclose(read.position, house_place(POLE))


def test_extrinsics_stand_in_for_tf(tmp_path):
    info, _ = camera_info(kinds)
    (tmp_path / 'pose.yaml').write_text(
        'translation: [100, 200, 600]\nrotation: [-0.9, 0, 0, 0.4358898943540674]\n'
    )
    path = bag(tmp_path / 'bag', (TOPIC, info))
    arguments = [path, tmp_path / 'north.xml', '--extrinsics', tmp_path / 'pose.yaml']
    result = run('convert-calibration', *arguments, '--unit', 'cm', '--to', 'opencv')
    assert result.exit_code == 0, result.exception
    read = read_calibration(tmp_path / 'north.xml', (720, 576)).camera
    np.testing.assert_allclose(read.position, POLE)


def test_what_is_missing_is_named(whole, tmp_path):
    with pytest.raises(CalibrationError, match=r'no transform from odom .*house, map, north_opt'):
        camera_from_bag(whole, TOPIC, HeardCamera('odom'))
    with pytest.raises(BagError, match='has no topic /south/camera_info'):
        camera_from_bag(whole, '/south/camera_info', HeardCamera('map'))
    with pytest.raises(CalibrationError, match='/tf holds no sensor_msgs/msg/CameraInfo but tf2'):
        camera_from_bag(whole, '/tf', HeardCamera('map'))
    only_tf = bag(tmp_path / 'tf', ('/tf', MOVING))
    with pytest.raises(CalibrationError, match=r'which topic .*on: none'):
        camera_from_bag(only_tf, '', HeardCamera('map'))


def test_one_of_several_cameras_has_to_be_named(tmp_path):
    info, _ = camera_info(kinds)
    two = bag(tmp_path / 'two', (TOPIC, info), ('/south/camera_info', info), ('/tf', STATIC))
    with pytest.raises(CalibrationError, match=r'on: /north/camera_info, /south/camera_info'):
        camera_from_bag(two, '', HeardCamera('map'))


def test_units_and_topics_that_say_nothing_are_refused(whole, tmp_path):
    result = run('convert-calibration', whole, tmp_path / 'a.yaml', '--unit', 'cm')
    assert 'TF is in metres' in str(result.exception)
    result = run('convert-calibration', tmp_path / 'no.yaml', tmp_path / 'a.yaml', '--topic', '/a')
    assert 'no.yaml: No such file' in str(result.exception)
