"""Frames and camera info say what the calibration does."""

import signal

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo

from mctrack_ros.cli.sites import named_site
from mctrack_ros.recording import BagReader
from mctrack_ros.ros.interop.camera_frames import TF_TYPE, camera_frames, camera_info
from mctrack_ros.ros.interop.made_types import TYPES, serialisable
from mctrack_ros.ros.nodes.camera_node import CameraNode
from mctrack_ros.ros.topics.quality import latched
from walker import camera_parameters


@pytest.fixture(scope='module')
def mapping():
    return named_site('pitch5').cameras['cam1'].mapping().moved((100.0, -50.0))


def frames(mapping):
    """Return the (4, 4) matrices from child to parent, by child."""
    message = TYPES.deserialize_cdr(camera_frames(mapping, 'cam1', 'map', 5 * 10**9), TF_TYPE)
    found = {}
    for each in message.transforms:
        shift, turn = each.transform.translation, each.transform.rotation
        matrix = np.eye(4)
        matrix[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
        matrix[:3, 3] = shift.x, shift.y, shift.z
        found[each.header.frame_id, each.child_frame_id] = matrix
    return found


def test_frames_and_lens_show_places_where_the_calibration_does(mapping):
    chain = frames(mapping)
    to_map = chain['map', 'cam1_link'] @ chain['cam1_link', 'cam1_optical_frame']
    places = mapping.visible_ground()[::200]
    world = np.column_stack([places, np.zeros(len(places)), np.ones(len(places))])
    seen = (np.linalg.inv(to_map) @ world.T)[:3].T
    info = camera_info(mapping, 'cam1', 0)
    pixels, _ = cv2.projectPoints(
        seen, np.zeros(3), np.zeros(3), np.reshape(info.k, (3, 3)), np.array(info.d)
    )
    assert len(places) > 5
    np.testing.assert_allclose(pixels[:, 0], mapping.image_from_ground(places), atol=0.51)
    assert (info.width, info.height) == mapping.image_size


def test_a_link_looks_along_x_and_has_z_up(mapping):
    link = frames(mapping)['map', 'cam1_link']
    np.testing.assert_allclose(link[:3, 3], mapping.camera_position)
    middle = np.array([mapping.image_size]) / 2
    aim = np.append(mapping.ground_from_image(middle)[0], 0.0) - mapping.camera_position
    assert aim @ link[:3, 0] > 0.99 * np.linalg.norm(aim)
    assert link[2, 2] > 0.9


def test_a_type_that_is_made_has_the_name_and_the_hash_of_the_real_one(bench):
    bench.open()
    publisher = bench.observer.create_publisher(serialisable(TF_TYPE), '/tf_static', 1)
    (info,) = bench.observer.get_publishers_info_by_topic('/tf_static')
    assert info.topic_type == TF_TYPE
    assert str(info.topic_type_hash) == TYPES.hash_rihs01(TF_TYPE)
    bench.observer.destroy_publisher(publisher)


def test_what_is_no_sequence_of_an_installed_type_is_not_made():
    with pytest.raises(ValueError, match='only sequences can be made'):
        serialisable('tf2_msgs/msg/TF2Error')
    with pytest.raises(ValueError, match='neither installed nor known'):
        serialisable('no_msgs/msg/Nothing')


@pytest.mark.live
def test_a_camera_node_tells_both_to_who_comes_later(bench, projection):
    bench.make(CameraNode, **camera_parameters(projection))
    kind, heard = serialisable(TF_TYPE), []
    bench.observer.create_subscription(kind, '/tf_static', heard.append, latched(), raw=True)
    infos = []
    bench.observer.create_subscription(CameraInfo, '/cam1/camera_info', infos.append, latched())
    bench.until(lambda: heard and infos)
    frames = TYPES.deserialize_cdr(heard[0], TF_TYPE).transforms
    assert [each.child_frame_id for each in frames] == ['cam1_link', 'cam1_optical_frame']
    assert infos[0].header.frame_id == 'cam1_optical_frame'


@pytest.mark.live
def test_frames_are_recorded_though_their_type_is_not_installed(bench, tmp_path, projection):
    bench.make(CameraNode, **camera_parameters(projection))
    bench.spawn('recorder', path=str(tmp_path / 'bag'), topics=['/tf_static'])
    bench.until(lambda: bench.observer.count_subscribers('/tf_static') == 1)
    empty = size_of(tmp_path / 'bag')
    bench.until(lambda: size_of(tmp_path / 'bag') > empty)
    for process in bench.processes:
        process.send_signal(signal.SIGINT)
        assert bench.exit_code(process) == 0
    with BagReader(tmp_path / 'bag') as reader:
        ((_, message, _),) = reader.messages(['/tf_static'])
    assert message.transforms[0].child_frame_id == 'cam1_link'


def size_of(folder):
    """Return the bytes in the files of a bag by now."""
    return sum(path.stat().st_size for path in folder.glob('*'))
