import cv2
import numpy as np
import pytest

from mctrack_ros.codec import image_message
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter
from mctrack_ros.web import ImageError, read_image
from mctrack_ros.web.image_source import image_topics

IMAGE = np.dstack([np.full((48, 64), level, np.uint8) for level in (20, 120, 220)])


@pytest.fixture
def bag(tmp_path):
    path = tmp_path / 'bag'
    with BagWriter(path) as writer:
        for camera in ('cam1', 'cam2'):
            message = image_message(IMAGE, ROSBAGS_CLASSES, 1, camera)
            writer.write(f'/{camera}/image_raw', message, 1)
        writer.write_text('/site', '{}', 1)
    return path


def test_an_image_file_is_read(tmp_path):
    cv2.imwrite(str(tmp_path / 'cam1.png'), IMAGE)
    np.testing.assert_array_equal(read_image(tmp_path / 'cam1.png', 'cam1'), IMAGE)


def test_the_first_image_of_a_video_is_read(tmp_path):
    path = tmp_path / 'cam1.avi'
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'MJPG'), 25, (64, 48))
    writer.write(IMAGE)
    writer.release()
    image = read_image(path, 'cam1')
    assert np.abs(image.astype(int) - IMAGE).max() < 12


def test_the_topic_of_a_bag_is_found_by_the_name_of_the_camera(bag):
    np.testing.assert_array_equal(read_image(bag, 'cam2'), IMAGE)
    np.testing.assert_array_equal(read_image(bag, 'north', '/cam1/image_raw'), IMAGE)


def test_a_bag_with_several_topics_asks_which(bag):
    with pytest.raises(ImageError, match='/cam1/image_raw, /cam2/image_raw'):
        read_image(bag, 'north')
    with pytest.raises(ImageError, match='no images'):
        read_image(bag, 'cam1', '/site')


@pytest.mark.parametrize(
    ('names', 'found'),
    [
        (['cam1/image_raw', 'cam1/image_raw/compressed'], ['cam1/image_raw/compressed']),
        (['cam1/image_raw/compressed', 'cam1/debug_image'], ['cam1/image_raw/compressed']),
        (['cam2/image_raw', 'cam1/image'], ['cam1/image']),
        (['cam2/image_raw'], ['cam2/image_raw']),
        (['cam2/image_raw', 'cam3/image_raw'], ['cam2/image_raw', 'cam3/image_raw']),
        (['cam1/detections'], []),
    ],
)
def test_the_topic_of_images_is_the_one_that_the_camera_takes(names, found):
    kinds = {'detections': 'sensor_msgs/msg/PointCloud2'}
    topics = {name: kinds.get(name.split('/')[-1], 'sensor_msgs/msg/Image') for name in names}
    assert image_topics(topics, 'cam1') == found


def test_what_is_no_image_is_refused(tmp_path):
    (tmp_path / 'text.png').write_text('no image')
    for name, reason in (('text.png', 'neither an image nor a video'), ('none', 'not exist')):
        with pytest.raises(ImageError, match=reason):
            read_image(tmp_path / name, 'cam1')
