"""A live topic as the source of a page's image."""

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import Image, PointCloud2

from mctrack_ros.codec import image_from_message
from mctrack_ros.recording import BagReader
from mctrack_ros.ros.topics import quality
from mctrack_ros.web import ImageError, read_image
from walker import SIZE

pytestmark = pytest.mark.live
BUSY_S = 60.0  # what a node may take to start on a busy machine


@pytest.fixture
def film(tmp_path):
    """Return a video file of ten grey images."""
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
    image = read_image('live', 'cam2', patience_s=BUSY_S)
    assert image.shape == (SIZE[1], SIZE[0], 3)
    assert np.median(np.abs(image.astype(int) - image_from_message(message))) < 8


@pytest.mark.parametrize('is_reliable', [False, True])
def test_a_raw_topic_is_read_whatever_quality_it_offers(bench, film, is_reliable):
    bench.spawn(
        'video_node', source=str(film), loop=True, image_topic='image_raw', reliable=is_reliable
    )
    image = read_image('live', 'north', 'cam1/image_raw', BUSY_S)
    assert abs(image.mean() - 90) < 2


def test_without_an_image_it_is_said_what_to_do(bench):
    with pytest.raises(ImageError, match=r'nobody publishes /north/image_raw within 0\.1 s'):
        read_image('live', 'north', '/north/image_raw', patience_s=0.1)
    with pytest.raises(ImageError, match=r'nobody publishes images .* start the camera'):
        read_image('live', 'north', patience_s=0.1)


def test_a_publisher_that_sends_nothing_and_one_of_no_images_are_told_apart(bench):
    bench.open()
    bench.observer.create_publisher(Image, '/cam1/image_raw', quality.images(False, 1))
    bench.observer.create_publisher(PointCloud2, '/tracks', quality.reliable(1))
    with pytest.raises(ImageError, match='/cam1/image_raw is published, but no image came'):
        read_image('live', 'cam1', '/cam1/image_raw', patience_s=5.0)
    with pytest.raises(ImageError, match='/tracks holds no images but sensor_msgs/msg/Point'):
        read_image('live', 'cam1', '/tracks', patience_s=BUSY_S)
