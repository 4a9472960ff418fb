import cv2
import numpy as np
import pytest

from mctrack_ros.codec import image_message
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter
from mctrack_ros.web import PictureError, read_picture
from mctrack_ros.web.picture_topic import picture_topics

PICTURE = np.dstack([np.full((48, 64), level, np.uint8) for level in (20, 120, 220)])


@pytest.fixture
def bag(tmp_path):
    path = tmp_path / 'bag'
    with BagWriter(path) as writer:
        for camera in ('cam1', 'cam2'):
            message = image_message(PICTURE, ROSBAGS_CLASSES, 1, camera)
            writer.write(f'/{camera}/image_raw', message, 1)
        writer.write_text('/site', '{}', 1)
    return path


def test_a_picture_file_is_read(tmp_path):
    cv2.imwrite(str(tmp_path / 'cam1.png'), PICTURE)
    np.testing.assert_array_equal(read_picture(tmp_path / 'cam1.png', 'cam1'), PICTURE)


def test_the_first_picture_of_a_video_is_read(tmp_path):
    path = tmp_path / 'cam1.avi'
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'MJPG'), 25, (64, 48))
    writer.write(PICTURE)
    writer.release()
    picture = read_picture(path, 'cam1')
    assert np.abs(picture.astype(int) - PICTURE).max() < 12


def test_the_topic_of_a_bag_is_found_by_the_name_of_the_camera(bag):
    np.testing.assert_array_equal(read_picture(bag, 'cam2'), PICTURE)
    np.testing.assert_array_equal(read_picture(bag, 'north', '/cam1/image_raw'), PICTURE)


def test_a_bag_with_several_topics_asks_which(bag):
    with pytest.raises(PictureError, match='/cam1/image_raw, /cam2/image_raw'):
        read_picture(bag, 'north')
    with pytest.raises(PictureError, match='no pictures'):
        read_picture(bag, 'cam1', '/site')


@pytest.mark.parametrize(
    ('names', 'found'),
    [
        (['cam1/image_raw', 'cam1/image_raw/compressed'], ['cam1/image_raw/compressed']),
        (['cam1/image_raw/compressed', 'cam1/debug_image'], ['cam1/image_raw/compressed']),
        (['cam2/image_raw', 'cam1/picture'], ['cam1/picture']),
        (['cam2/image_raw'], ['cam2/image_raw']),
        (['cam2/image_raw', 'cam3/image_raw'], ['cam2/image_raw', 'cam3/image_raw']),
        (['cam1/detections'], []),
    ],
)
def test_the_topic_of_pictures_is_the_one_that_the_camera_takes(names, found):
    kinds = {'detections': 'sensor_msgs/msg/PointCloud2'}
    topics = {name: kinds.get(name.split('/')[-1], 'sensor_msgs/msg/Image') for name in names}
    assert picture_topics(topics, 'cam1') == found


def test_what_is_no_picture_is_refused(tmp_path):
    (tmp_path / 'text.png').write_text('no picture')
    for name, reason in (('text.png', 'neither a picture nor a video'), ('none', 'not exist')):
        with pytest.raises(PictureError, match=reason):
            read_picture(tmp_path / name, 'cam1')
