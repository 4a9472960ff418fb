import array
import struct
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from builtin_interfaces.msg import Time
from hypothesis import given, settings
from sensor_msgs.msg import CompressedImage, Image, PointCloud2, PointField
from std_msgs.msg import Header
from strategies import ROW_TYPES, rows

from mctrack_ros.codec import (
    CodecError,
    MessageClasses,
    cloud_from_rows,
    compressed_message,
    image_from_message,
    image_message,
    jpeg_from_image,
    rows_from_cloud,
    stamp_ns_of,
)
from mctrack_ros.interfaces import Detections, Ticks, Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES

RCLPY_CLASSES = MessageClasses(
    PointCloud2,
    PointField,
    Header,
    Time,
    Image,
    CompressedImage,
    lambda octets: array.array('B', octets.tobytes()),
)
BOTH = pytest.mark.parametrize(
    'classes', [RCLPY_CLASSES, ROSBAGS_CLASSES], ids=['rclpy', 'rosbags']
)


def slow_decode(message, name):
    """Read one field of every row by the message's own description, a number at a time."""
    codes = {2: 'B', 4: 'H', 6: 'I', 7: 'f'}
    field = next(field for field in message.fields if field.name == name)
    data = bytes(message.data)
    for row in range(message.width):
        start = row * message.point_step + field.offset
        yield struct.unpack_from(f'<{field.count}{codes[field.datatype]}', data, start)


@BOTH
@settings(max_examples=60, deadline=None)
@given(given_rows=rows())
def test_rows_survive_the_round_trip_bit_by_bit(classes, given_rows):
    message = cloud_from_rows(given_rows, classes, 'map')
    back = rows_from_cloud(message, type(given_rows))
    assert back.stamp_ns == given_rows.stamp_ns
    for name in given_rows.COLUMNS:
        assert getattr(back, name).tobytes() == getattr(given_rows, name).tobytes(), name


@settings(max_examples=30, deadline=None)
@given(given_rows=rows())
def test_both_implementations_get_the_same_bytes(given_rows):
    one = cloud_from_rows(given_rows, RCLPY_CLASSES, 'map')
    other = cloud_from_rows(given_rows, ROSBAGS_CLASSES, 'map')
    assert bytes(one.data) == bytes(other.data)


@settings(max_examples=30, deadline=None)
@given(given_rows=rows(kinds=(Tracks,)))
def test_a_slow_reader_finds_the_same_values(given_rows):
    message = cloud_from_rows(given_rows, ROSBAGS_CLASSES, 'map')
    assert [v[0] for v in slow_decode(message, 'track_id')] == given_rows.track_id.tolist()
    upper = np.triu_indices(4)
    expected = given_rows.covariance[:, upper[0], upper[1]].tolist()
    assert [list(v) for v in slow_decode(message, 'covariance')] == expected


@pytest.mark.parametrize('kind', ROW_TYPES)
def test_layout_keeps_the_rules(kind):
    message = cloud_from_rows(kind.build(1), ROSBAGS_CLASSES, 'map')
    sizes = [{2: 1, 4: 2, 6: 4, 7: 4}[field.datatype] for field in message.fields]
    assert message.point_step % 4 == 0
    assert sizes == sorted(sizes, reverse=True)
    assert [field.name for field in message.fields[:3]] == ['x', 'y', 'z']
    assert len(message.fields) == len(kind.COLUMNS) + 2


def test_golden_bytes_of_a_tick():
    row = Ticks.build(
        1_500_000_000, position=[[1, 2, 3]], camera=[1], admitted=[2], late=[0x01020304], alive=[1]
    )
    message = cloud_from_rows(row, ROSBAGS_CLASSES, 'map')
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert bytes(message.data).hex(' ', 4) == (
        '0000803f 00000040 00004040 '  # x, y, z
        '01000000 02000000 00000000 '  # camera, admitted, detections
        '04030201 00000000 00000000 '  # late, dropped_detections, feedback_missed
        '00010000'  # missing, alive, padding
    )


def test_unknown_positions_make_the_cloud_not_dense():
    unknown = Tracks.build(1, track_id=[1])
    assert not cloud_from_rows(unknown, ROSBAGS_CLASSES, 'map').is_dense
    known = Tracks.build(1, position=[[0, 0, 0]])
    assert cloud_from_rows(known, ROSBAGS_CLASSES, 'map').is_dense


def broken(**changes):
    """Return a good cloud of one detection with some members exchanged."""
    row = Detections.build(1, position=[[0, 0, 0]])
    message = cloud_from_rows(row, ROSBAGS_CLASSES, 'map')
    members = {name: getattr(message, name) for name in message.__dataclass_fields__}
    return SimpleNamespace(**(members | changes))


def fields_without(name):
    return [field for field in broken().fields if field.name != name]


def fields_with(name, **changes):
    return [
        SimpleNamespace(
            **({n: getattr(f, n) for n in ('name', 'offset', 'datatype', 'count')} | changes)
        )
        if f.name == name
        else f
        for f in broken().fields
    ]


@pytest.mark.parametrize(
    ('message', 'reason'),
    [
        (broken(fields=fields_without('box')), "lacks the field 'box'"),
        (broken(fields=fields_with('box', datatype=8)), 'is 4 x f8, expected 4 x f4'),
        (broken(fields=fields_with('box', datatype=99)), 'is 4 x unknown'),
        (broken(fields=fields_with('box', count=2)), 'is 2 x f4, expected 4 x f4'),
        (broken(fields=fields_with('kit', offset=4000)), 'exceeds its point_step'),
        (broken(is_bigendian=True), 'big-endian'),
        (broken(width=2), 'a cloud of 2 Detections holds'),
        (broken(data=np.zeros(3, np.uint8)), 'holds 3 bytes'),
        (broken(point_step=0), 'exceeds its point_step'),
    ],
)
def test_wrong_clouds_are_refused_with_the_reason(message, reason):
    with pytest.raises(CodecError, match=reason):
        rows_from_cloud(message, Detections)


@pytest.mark.parametrize('value', [np.nan, np.inf, -np.inf])
def test_numbers_that_must_be_finite_are(value):
    row = Detections.build(1, position=[[0, 0, 0]], score=[value])
    with pytest.raises(CodecError, match='score of row 0 is not finite'):
        rows_from_cloud(cloud_from_rows(row, ROSBAGS_CLASSES, 'map'), Detections)


def test_a_dense_cloud_with_an_unknown_position_is_refused():
    row = Detections.build(1, score=[1.0])
    message = cloud_from_rows(row, ROSBAGS_CLASSES, 'map')
    message.is_dense = True
    with pytest.raises(CodecError, match='position of row 0'):
        rows_from_cloud(message, Detections)


def test_further_fields_are_passed_over():
    tracks = Tracks.build(5, position=[[1, 2, 0]], track_id=[9])
    message = cloud_from_rows(tracks, ROSBAGS_CLASSES, 'map')
    step = message.point_step + 4
    data = np.zeros((1, step), np.uint8)
    data[:, : message.point_step] = message.data
    extra = SimpleNamespace(name='extra', offset=message.point_step, datatype=7, count=1)
    wider = SimpleNamespace(
        **(
            {n: getattr(message, n) for n in message.__dataclass_fields__}
            | {'fields': [*message.fields, extra], 'point_step': step, 'data': data.reshape(-1)}
        )
    )
    assert rows_from_cloud(wider, Tracks).track_id.tolist() == [9]


@BOTH
def test_raw_pictures_survive_the_round_trip(classes):
    picture = np.random.default_rng(1).integers(0, 256, (6, 10, 3), np.uint8)
    message = image_message(picture, classes, 3, 'cam1_optical_frame')
    assert stamp_ns_of(message) == 3
    np.testing.assert_array_equal(image_from_message(message), picture)


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
    monkeypatch.setattr('mctrack_ros.codec.simplejpeg', None)
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
