"""A camera's calibration from a running graph, whose publishers speak once or often."""

import threading
from importlib.util import find_spec

import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from typer.testing import CliRunner

from mctrack_ros.cli.main import app
from mctrack_ros.ground import CalibrationError, HeardCamera, Pose, read_calibration
from mctrack_ros.ros.topics.hear_camera import camera_from_topic
from mctrack_ros.ros.topics.messages import message_class
from ros_cameras import (
    DOWN_TURN,
    HOUSE,
    HOUSE_TURN,
    POLE,
    camera_info,
    house_place,
    transforms,
)

TOPIC = '/north/camera_info'
POSE = Pose.of_frame(POLE, DOWN_TURN)
KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PATIENCE_S = 20.0
SHORT_S = 2.0


class Talker:
    """Publishers in a context of their own; some speak once, some at 20 Hz."""

    def __init__(self, domain):
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node('talker', context=self.context)
        self.again = []
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.talk)
        self.thread.start()

    def say(self, topic, message, quality, again=False):
        publisher = self.node.create_publisher(type(message), topic, quality)
        publisher.publish(message)
        if again:
            self.again.append((publisher, message))

    def talk(self):
        while not self.ended.wait(0.05):
            for publisher, message in list(self.again):
                publisher.publish(message)

    def close(self):
        self.ended.set()
        self.thread.join()
        self.node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture
def talker(domain, monkeypatch):
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
    made = Talker(domain)
    yield made
    made.close()


def kinds(name):
    return message_class(name)


@pytest.fixture
def info():
    message, _ = camera_info(kinds)
    return message


@pytest.mark.parametrize(
    ('quality', 'again'), [(KEPT, False), (qos_profile_sensor_data, True)], ids=['kept', 'live']
)
def test_an_info_said_once_or_again_is_heard(talker, info, quality, again):
    talker.say(TOPIC, info, quality, again)
    camera = camera_from_topic(TOPIC, HeardCamera('map', POSE), PATIENCE_S)
    np.testing.assert_allclose(camera.intrinsics, camera_info(kinds)[1].intrinsics)
    assert camera.pose is POSE


def test_static_and_moving_transforms_are_chained(talker, info):
    pytest.importorskip('tf2_msgs', reason='tf2_msgs is not among the wheels')
    talker.say(TOPIC, info, KEPT)
    talker.say('/tf_static', transforms(kinds, ('map', 'house', HOUSE, HOUSE_TURN)), KEPT)
    moving = transforms(kinds, ('house', 'north_optical_frame', POLE, DOWN_TURN))
    talker.say('/tf', moving, QoSProfile(depth=100), again=True)
    camera = camera_from_topic(TOPIC, HeardCamera('map'), PATIENCE_S)
    place = -camera.pose.rotation.T @ camera.pose.translation
    np.testing.assert_allclose(place, house_place(POLE), atol=1e-9)


def test_the_command_writes_what_it_heard(talker, info, tmp_path):
    talker.say(TOPIC, info, qos_profile_sensor_data, again=True)
    (tmp_path / 'pose.yaml').write_text(
        f'translation: {list(POLE)}\nrotation: {np.array(DOWN_TURN).tolist()}\n'
    )
    command = ['convert-calibration', TOPIC, str(tmp_path / 'north.xml'), '--to', 'opencv']
    command += ['--extrinsics', str(tmp_path / 'pose.yaml'), '--timeout', str(PATIENCE_S)]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.exception
    read = read_calibration(tmp_path / 'north.xml', (720, 576)).camera
    np.testing.assert_allclose(read.position, POLE)


def test_without_a_transform_it_is_said_which(talker, info):
    pytest.importorskip('tf2_msgs', reason='tf2_msgs is not among the wheels')
    talker.say(TOPIC, info, KEPT)
    with pytest.raises(CalibrationError, match='no transform from map to north_optical_frame'):
        camera_from_topic(TOPIC, HeardCamera('map'), SHORT_S)


@pytest.mark.skipif(find_spec('tf2_msgs') is not None, reason='tf2_msgs is installed')
def test_where_tf_has_no_messages_extrinsics_are_asked_for():
    with pytest.raises(
        CalibrationError, match=r'tf2_msgs/msg/TFMessage.* not installed: name ext'
    ):
        camera_from_topic(TOPIC, HeardCamera('map'), PATIENCE_S)


def test_what_there_is_instead_of_the_topic_is_listed(talker, info):
    talker.say('/south/camera_info', info, KEPT)
    with pytest.raises(CalibrationError) as refused:
        camera_from_topic(TOPIC, HeardCamera('map', POSE), SHORT_S)
    assert str(refused.value) == (
        '/north/camera_info: no sensor_msgs/CameraInfo within 2 s; nobody publishes on it '
        '(camera infos on: /south/camera_info)'
    )


def test_a_topic_of_another_type_is_named(talker):
    talker.say(TOPIC, kinds('std_msgs/msg/String')(data='no info'), KEPT)
    with pytest.raises(CalibrationError, match='within 2 s: it holds std_msgs/msg/String'):
        camera_from_topic(TOPIC, HeardCamera('map', POSE), SHORT_S)


def test_an_uncalibrated_camera_is_refused_at_once(talker, info):
    info.k = np.zeros(9)
    talker.say(TOPIC, info, KEPT)
    with pytest.raises(CalibrationError, match=r'/north/camera_info: .*not calibrated'):
        camera_from_topic(TOPIC, HeardCamera('map', POSE), PATIENCE_S)
