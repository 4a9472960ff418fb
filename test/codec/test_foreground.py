"""Masks as PNG of one bit a pixel."""

import pickle

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mctrack_ros.codec import (
    CodecError,
    cloud_from_rows,
    jpeg_from_image,
    message_from_ros,
    ros_from_message,
    stamp_ns_of,
)
from mctrack_ros.interfaces import Detections, Foreground
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES

BOTH = pytest.mark.parametrize(
    'classes', [RCLPY_CLASSES, ROSBAGS_CLASSES], ids=['rclpy', 'rosbags']
)
MASKS = arrays(
    np.uint8,
    st.tuples(st.integers(1, 40), st.integers(1, 40)),
    elements=st.sampled_from([0, 255]),
)


def sent(mask, classes=ROSBAGS_CLASSES, stamp_ns=1_234_567_890_123):
    return ros_from_message(Foreground(stamp_ns, mask), classes, 'map')


@BOTH
@settings(max_examples=30, deadline=None)
@given(mask=MASKS)
def test_a_mask_comes_back_as_it_was(classes, mask):
    message = sent(mask, classes)
    back = message_from_ros(message, Foreground)
    assert back.stamp_ns == stamp_ns_of(message) == 1_234_567_890_123
    np.testing.assert_array_equal(back.mask, mask)
    assert len(back) == np.count_nonzero(mask)


@BOTH
def test_an_unknown_mask_has_no_data(classes):
    message = ros_from_message(Foreground.build(7), classes, 'map')
    assert len(message.data) == 0
    back = message_from_ros(message, Foreground)
    assert (back.stamp_ns, back.mask.shape) == (7, (0, 0))


def test_other_programs_read_it_and_it_is_small():
    mask = np.zeros((72, 90), np.uint8)
    mask[20:45, 30:37] = mask[10:30, 60:66] = 255
    message = sent(mask)
    assert (message.format, message.header.frame_id) == ('png', 'map')
    np.testing.assert_array_equal(cv2.imdecode(message.data, cv2.IMREAD_UNCHANGED), mask)
    assert len(message.data) < 200


def test_any_grey_but_black_is_foreground():
    message = sent(np.zeros((2, 3), np.uint8))
    grey = np.array([[0, 1, 128], [255, 0, 0]], np.uint8)
    message.data = cv2.imencode('.png', grey)[1].reshape(-1)
    assert message_from_ros(message, Foreground).mask.tolist() == [[0, 255, 255], [255, 0, 0]]


def bombs():
    png = bytes(sent(np.full((30, 40), 255, np.uint8)).data)
    huge = bytearray(png)
    huge[16:24] = (1 << 20).to_bytes(4) + (1 << 20).to_bytes(4)
    flat = bytearray(png)
    flat[16:20] = bytes(4)
    jpeg = jpeg_from_image(np.zeros((8, 8, 3), np.uint8)).tobytes()
    return {
        'text': b'no picture', 'one byte': b'\x89', 'start': png[:8], 'head': png[:30],
        'huge': bytes(huge), 'no width': bytes(flat), 'jpeg': jpeg,
    }  # fmt: skip


@pytest.mark.parametrize('name', bombs())
def test_what_is_no_png_of_a_mask_is_refused(name):
    message = sent(np.zeros((2, 3), np.uint8))
    message.data = np.frombuffer(bombs()[name], np.uint8)
    with pytest.raises(CodecError, match='bytes of a mask cannot be decompressed: expected a PNG'):
        message_from_ros(message, Foreground)


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=200), st.integers(0, 100))
def test_garbage_is_refused_or_a_mask(data, kept):
    message = sent(np.full((9, 9), 255, np.uint8))
    message.data = np.frombuffer(bytes(message.data)[:kept] + data, np.uint8)
    try:
        mask = message_from_ros(message, Foreground).mask
    except CodecError:
        return
    assert set(np.unique(mask).tolist()) <= {0, 255}


def test_rows_still_travel_as_clouds():
    rows = Detections.build(5, position=[[1.0, 2.0, 0.0]])
    message = ros_from_message(rows, ROSBAGS_CLASSES, 'map')
    assert bytes(message.data) == bytes(cloud_from_rows(rows, ROSBAGS_CLASSES, 'map').data)
    assert message_from_ros(message, Detections).position.tolist() == [[1.0, 2.0, 0.0]]


@pytest.mark.parametrize('mask', [np.zeros(4, np.uint8), np.zeros((2, 2), bool)])
def test_what_is_no_mask_is_refused(mask):
    with pytest.raises(ValueError, match=r'expected \(height, width\) and uint8'):
        Foreground(0, mask)


@pytest.mark.parametrize('shape', [(0, 0), (1, 1), (7, 5), (72, 90)])
def test_a_mask_goes_to_another_process_as_it_is(shape):
    mask = np.random.default_rng(0).integers(0, 2, shape, np.uint8) * np.uint8(255)
    sent = pickle.dumps(Foreground(17, mask))
    assert len(sent) < mask.size / 8 + 200
    arrived = pickle.loads(sent)
    assert arrived.stamp_ns == 17
    assert np.array_equal(arrived.mask, mask)
    assert not arrived.mask.flags.writeable
