from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from mctrack_ros.codec import (
    CodecError,
    compressed_message,
    image_from_message,
    image_message,
    jpeg_from_image,
    stamp_ns_of,
)
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.ros.messages import RCLPY_CLASSES

BOTH = pytest.mark.parametrize(
    'classes', [RCLPY_CLASSES, ROSBAGS_CLASSES], ids=['rclpy', 'rosbags']
)


@BOTH
def test_raw_pictures_survive_the_round_trip(classes):
    picture = np.random.default_rng(1).integers(0, 256, (6, 10, 3), np.uint8)
    message = image_message(picture, classes, 3, 'cam1_optical_frame')
    assert stamp_ns_of(message) == 3
    np.testing.assert_array_equal(image_from_message(message), picture)


@BOTH
def test_grey_pictures_come_back_with_three_channels_alike(classes):
    picture = np.random.default_rng(1).integers(0, 256, (6, 10), np.uint8)
    message = image_message(picture, classes, 3, 'cam1_optical_frame')
    assert (message.encoding, message.step, len(message.data)) == ('mono8', 10, 60)
    np.testing.assert_array_equal(image_from_message(message), np.dstack([picture] * 3))


@BOTH
def test_compressed_pictures_come_back_alike(classes):
    column = np.linspace(0, 255, 64, dtype=np.uint8)
    picture = np.repeat(np.tile(column, (48, 1))[:, :, None], 3, axis=2)
    message = compressed_message(jpeg_from_image(picture), classes, 3, 'cam1_optical_frame')
    back = image_from_message(message)
    assert back.shape == picture.shape
    assert np.abs(back.astype(int) - picture).mean() < 3


@pytest.mark.parametrize(
    ('encoding', 'channels', 'code'),
    [
        ('mono8', 1, cv2.COLOR_GRAY2BGR),
        ('rgb8', 3, cv2.COLOR_RGB2BGR),
        ('bgra8', 4, cv2.COLOR_BGRA2BGR),
        ('rgba8', 4, cv2.COLOR_RGBA2BGR),
    ],
)
def test_other_encodings_become_bgr_and_row_padding_is_skipped(encoding, channels, code):
    picture = np.random.default_rng(1).integers(0, 256, (4, 5, channels), np.uint8)
    step = 5 * channels + 3
    data = np.zeros((4, step), np.uint8)
    data[:, : 5 * channels] = picture.reshape(4, -1)
    message = SimpleNamespace(encoding=encoding, height=4, width=5, step=step, data=data.tobytes())
    np.testing.assert_array_equal(image_from_message(message), cv2.cvtColor(picture, code))


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'data': b''}, 'the image is empty'),
        ({'encoding': '32FC1'}, "encoding '32FC1' is not known"),
        ({'width': 7}, 'holds 60 bytes, expected 84'),
        ({'height': 5}, 'holds 60 bytes, expected 75'),
        ({'step': 1}, 'with step 1'),
        ({'width': 0, 'step': 0}, 'holds 60 bytes'),
    ],
)
def test_wrong_pictures_are_refused_with_the_reason(changes, reason):
    good = {'encoding': 'bgr8', 'height': 4, 'width': 5, 'step': 15, 'data': bytes(60)}
    with pytest.raises(CodecError, match=reason):
        image_from_message(SimpleNamespace(**(good | changes)))


def test_jpeg_gives_the_pixels_that_opencv_gives():
    picture = np.random.default_rng(1).integers(0, 256, (48, 64, 3), np.uint8)
    jpeg = jpeg_from_image(cv2.GaussianBlur(picture, (5, 5), 0))
    decoded = image_from_message(SimpleNamespace(format='jpeg', data=jpeg.tobytes()))
    np.testing.assert_array_equal(decoded, cv2.imdecode(jpeg, cv2.IMREAD_COLOR))


def test_without_simplejpeg_opencv_decompresses(monkeypatch):
    monkeypatch.setattr('mctrack_ros.codec.images.simplejpeg', None)
    jpeg = jpeg_from_image(np.full((48, 64, 3), 90, np.uint8))
    decoded = image_from_message(SimpleNamespace(format='jpeg', data=jpeg.tobytes()))
    assert decoded.shape == (48, 64, 3)


def test_png_is_read_too():
    picture = np.random.default_rng(1).integers(0, 256, (6, 7, 3), np.uint8)
    data = cv2.imencode('.png', picture)[1].tobytes()
    decoded = image_from_message(SimpleNamespace(format='png', data=data))
    np.testing.assert_array_equal(decoded, picture)


def test_a_cut_off_jpeg_is_refused():
    message = SimpleNamespace(format='jpeg', data=b'\xff\xd8\xff\xe0 cut off')
    with pytest.raises(CodecError, match=r'JPEG image|decompressed'):
        image_from_message(message)
