"""A live topic as the source of a page's picture."""

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import Image, PointCloud2

from mctrack_ros.codec import image_from_message
from mctrack_ros.recording import BagReader
from mctrack_ros.ros.topics import quality
from mctrack_ros.web import PictureError, read_picture
from walker import SIZE

pytestmark = pytest.mark.live
BUSY_S = 60.0  # what a node may take to start on a busy machine


@pytest.fixture
def film(tmp_path):
    """Return a video file of ten grey pictures."""
    path = tmp_path / 'film.avi'
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'MJPG'), 25.0, SIZE)
    for _ in range(10):
        writer.write(np.full((SIZE[1], SIZE[0], 3), 90, np.uint8))
    writer.release()
    return path


def test_a_compressed_topic_is_found_by_the_name_of_the_camera(bench, walker_bag):
    with BagReader(walker_bag) as bag:
        message = next(bag.messages(['/cam2/image_raw/compressed']))[1]
    bench.spawn('player', path=str(walker_bag), loop=True, wait=0.0)
    picture = read_picture('live', 'cam2', patience_s=BUSY_S)
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    assert np.median(np.abs(picture.astype(int) - image_from_message(message))) < 8


@pytest.mark.parametrize('is_reliable', [False, True])
def test_a_raw_topic_is_read_whatever_quality_it_offers(bench, film, is_reliable):
    bench.spawn(
        'video_node', source=str(film), loop=True, image_topic='image_raw', reliable=is_reliable
    )
    picture = read_picture('live', 'north', 'cam1/image_raw', BUSY_S)
    assert abs(picture.mean() - 90) < 2


def test_without_a_picture_it_is_said_what_to_do(bench):
    with pytest.raises(PictureError, match=r'nobody publishes /north/image_raw within 0\.1 s'):
        read_picture('live', 'north', '/north/image_raw', patience_s=0.1)
    with pytest.raises(PictureError, match=r'nobody publishes pictures .* start the camera'):
        read_picture('live', 'north', patience_s=0.1)


def test_a_publisher_that_sends_nothing_and_one_of_no_pictures_are_told_apart(bench):
    bench.open()
    bench.observer.create_publisher(Image, '/cam1/image_raw', quality.images(False, 1))
    bench.observer.create_publisher(PointCloud2, '/tracks', quality.reliable(1))
    with pytest.raises(PictureError, match='/cam1/image_raw is published, but no picture came'):
        read_picture('live', 'cam1', '/cam1/image_raw', patience_s=5.0)
    with pytest.raises(PictureError, match='/tracks holds no pictures but sensor_msgs/msg/Point'):
        read_picture('live', 'cam1', '/tracks', patience_s=BUSY_S)
