import dataclasses

import numpy as np
import pytest

from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.recording import ROSBAGS_CLASSES, BagError, BagWriter
from mctrack_ros.replay.camera_source import CameraSource, CameraTask
from mctrack_ros.resources import config_file
from mctrack_ros.site.site import load_site

PERIOD_NS = 40_000_000
GOOD = jpeg_from_image(np.full((576, 768, 3), 90, np.uint8))
SMALL = jpeg_from_image(np.full((288, 384, 3), 90, np.uint8))
BROKEN = np.frombuffer(b'no image at all', np.uint8)


def source(folder, images):
    with BagWriter(folder / 'bag') as bag:
        for index, jpeg in enumerate(images):
            stamp_ns = (index + 1) * PERIOD_NS
            message = compressed_message(jpeg, ROSBAGS_CLASSES, stamp_ns, 'cam1_optical_frame')
            bag.write('/cam1/image_raw/compressed', message, stamp_ns)
    settings = load_site(config_file('pitch5.yaml')).cameras['cam1']
    settings = dataclasses.replace(settings, image_topic='image_raw/compressed')
    task = CameraTask(folder / 'bag', 'cam1', settings, PERIOD_NS, 2 * PERIOD_NS)
    return CameraSource(task)


def test_broken_images_and_those_of_another_size_are_passed_over(tmp_path):
    camera = source(tmp_path, [GOOD, SMALL, BROKEN, GOOD, GOOD])
    stamps = []
    while camera.next_stamp_ns is not None:
        stamps.append(camera.step().stamp_ns // PERIOD_NS)
    assert stamps == [1, 4, 5]
    assert camera.quality.refused == 2


def test_a_huge_image_is_passed_over_undecoded(tmp_path):
    huge = GOOD.copy()
    at = huge.tobytes().index(b'\xff\xc0')
    huge[at + 5 : at + 9] = 0xFF
    camera = source(tmp_path, [GOOD, huge, GOOD])
    while camera.next_stamp_ns is not None:
        camera.step()
    assert camera.quality.refused == 1


def test_a_bag_without_any_usable_image_is_refused(tmp_path):
    with pytest.raises(BagError, match='no image on /cam1/image_raw/compressed can be used'):
        source(tmp_path, [SMALL, BROKEN])


def images_on(folder, topics):
    """Write a bag with one image on each topic."""
    with BagWriter(folder / 'bag') as bag:
        for topic in topics:
            message = compressed_message(GOOD, ROSBAGS_CLASSES, PERIOD_NS, 'optical')
            bag.write(topic, message, PERIOD_NS)
    return folder / 'bag'


def opened(bag, image_topic='image_raw/compressed', namespace=''):
    settings = load_site(config_file('pitch5.yaml')).cameras['cam1']
    settings = dataclasses.replace(settings, image_topic=image_topic)
    return CameraSource(CameraTask(bag, 'cam1', settings, PERIOD_NS, 2 * PERIOD_NS, namespace))


@pytest.mark.parametrize(
    ('topic', 'image_topic', 'namespace'),
    [
        ('/hall/cam1/image_raw/compressed', 'image_raw/compressed', '/hall'),
        ('/hall/cam1/image_raw/compressed', '/hall/cam1/image_raw/compressed', ''),
        ('/hall/cam1/image_raw/compressed', '/hall/cam1/image_raw/compressed', '/hall'),
        ('/D455_1/color/compressed', '/D455_1/color/compressed', ''),
        ('/D455_1/color/compressed', '/D455_1/color/compressed', '/hall'),
    ],
)
def test_images_are_found_wherever_they_lie(tmp_path, topic, image_topic, namespace):
    camera = opened(images_on(tmp_path, [topic]), image_topic, namespace)
    assert camera.next_stamp_ns == PERIOD_NS


def test_in_a_namespace_cameras_elsewhere_of_the_same_name_are_not_mixed_in(tmp_path):
    topics = ['/cam1/image_raw/compressed', '/hall/cam1/image_raw/compressed']
    bag = images_on(tmp_path, topics)
    for namespace in ('', '/hall'):
        camera = opened(bag, namespace=namespace)
        camera.step()
        assert camera.next_stamp_ns is None
        assert camera.quality.refused == 0


@pytest.mark.parametrize(
    ('topics', 'hint'),
    [
        (['/hall/cam1/image_raw/compressed'], 'give --namespace /hall'),
        (['/a/b/cam1/detections'], 'give --namespace /a/b'),
        (['/North/image_raw/compressed'], 'its cameras are North; give the site of these'),
        (
            ['/D455_1/color/image_raw', '/D455_2/color/image_raw'],
            'its images are on /D455_1/color/image_raw, /D455_2/color/image_raw; name them in',
        ),
        (['/hall/cam7/image_raw/compressed'], 'its images are on /hall/cam7/image_raw/comp'),
        (['/1st/image_raw/compressed'], 'its images are on /1st/image_raw/compressed'),
    ],
)
def test_what_a_bag_has_instead_is_said_with_what_to_do(tmp_path, topics, hint):
    with pytest.raises(BagError, match=hint):
        opened(images_on(tmp_path, topics))
