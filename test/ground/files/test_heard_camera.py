"""A camera from messages: what is missing, and images that are a part of the sensor's."""

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from mctrack_ros.ground import CalibrationError, HeardCamera, Pose
from ros_cameras import DOWN_TURN, POLE, camera_info, transforms

kinds = get_typestore(Stores.ROS2_JAZZY).types.__getitem__
POSE = Pose.of_frame(POLE, DOWN_TURN)


def test_a_camera_is_there_once_info_and_transform_are():
    info, stored = camera_info(kinds)
    heard = HeardCamera('map')
    assert heard.camera() is None
    assert heard.missing() == 'no sensor_msgs/CameraInfo'
    heard.hear_info(info)
    assert heard.camera() is None
    assert 'no transform from map to north_optical_frame (frames in TF: none)' in heard.missing()
    heard.hear_transforms(transforms(kinds, ('world', 'north_optical_frame', POLE, DOWN_TURN)))
    assert heard.camera() is None
    assert '(frames in TF: north_optical_frame, world)' in heard.missing()
    heard.hear_transforms(transforms(kinds, ('map', 'world', (0, 0, 0), (0, 0, 0, 1))))
    camera = heard.camera()
    np.testing.assert_allclose(camera.intrinsics, stored.intrinsics)
    np.testing.assert_allclose(camera.pose.translation, POSE.translation)


def test_a_pose_of_its_own_replaces_tf():
    heard = HeardCamera('map', POSE)
    heard.hear_info(camera_info(kinds, frame='')[0])
    assert heard.camera().pose is POSE


def test_an_info_without_a_frame_is_refused():
    heard = HeardCamera('map')
    heard.hear_info(camera_info(kinds, frame='')[0])
    with pytest.raises(CalibrationError, match='names no frame_id'):
        heard.camera()


def test_binning_and_region_of_interest_give_the_images_that_are_sent():
    whole, _ = camera_info(kinds)
    part, _ = camera_info(kinds, binning=2, region=(100, 50, 400, 300))
    cameras = []
    for info in (whole, part):
        heard = HeardCamera('map', POSE)
        heard.hear_info(info)
        camera = heard.camera()
        cameras.append(camera.mapping(camera.image_size))
    assert cameras[1].image_size == (200, 150)
    pixel = np.array([[150.0, 90], [300, 200], [480, 330]])
    np.testing.assert_allclose(
        cameras[1].ground_from_image((pixel - (100, 50)) / 2),
        cameras[0].ground_from_image(pixel),
        rtol=1e-9,
    )
