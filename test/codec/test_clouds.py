import struct
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings

from mctrack_ros.codec import (
    CodecError,
    cloud_from_rows,
    fields_of_cloud,
    rows_from_cloud,
)
from mctrack_ros.fusion.measurements.admission import usable_rows
from mctrack_ros.interfaces import Detections, Events, Feedback, Ticks, Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from strategies import ROW_TYPES, rows

BOTH = pytest.mark.parametrize(
    'classes', [RCLPY_CLASSES, ROSBAGS_CLASSES], ids=['rclpy', 'rosbags']
)


def slow_decode(message, name):
    """Read one field of every row by the message's own description, a number at a time."""
    codes = {2: 'B', 4: 'H', 5: 'i', 6: 'I', 7: 'f'}
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
def test_every_field_is_read_by_the_messages_own_description(given_rows):
    fields = fields_of_cloud(cloud_from_rows(given_rows, ROSBAGS_CLASSES, 'map'))
    for name, column in given_rows.COLUMNS.items():
        values = getattr(given_rows, name)
        if name == 'position':
            np.testing.assert_array_equal(np.column_stack([fields[x] for x in 'xyz']), values)
            continue
        if len(column.shape) == 2:
            values = values[:, *np.triu_indices(column.shape[0])]
        assert fields[name].dtype == values.dtype
        np.testing.assert_array_equal(fields[name], values, name)


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
    sizes = [{2: 1, 4: 2, 5: 4, 6: 4, 7: 4}[field.datatype] for field in message.fields]
    assert message.point_step % 4 == 0
    assert sizes == sorted(sizes, reverse=True)
    assert [field.name for field in message.fields[:3]] == ['x', 'y', 'z']
    assert len(message.fields) == len(kind.COLUMNS) + 2


def test_golden_bytes_of_a_tick():
    row = Ticks.build(
        1_500_000_000,
        position=[[1, 2, 3]],
        camera=[1],
        admitted=[2],
        late=[0x01020304],
        alive=[1],
        left_out=[5],
        added_ms=[-50],
        age_us=[6],
    )
    message = cloud_from_rows(row, ROSBAGS_CLASSES, 'map')
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 500_000_000)
    assert bytes(message.data).hex(' ', 4) == (
        '0000803f 00000040 00004040 '  # x, y, z
        '01000000 02000000 00000000 '  # camera, admitted, detections
        '04030201 00000000 00000000 '  # late, dropped_detections, feedback_missed
        '05000000 ceffffff 06000000 '  # left_out, added_ms, age_us
        '00010000'  # missing, alive, padding
    )


def test_unknown_positions_make_the_cloud_not_dense():
    unknown = Tracks.build(1, track_id=[1])
    assert not cloud_from_rows(unknown, ROSBAGS_CLASSES, 'map').is_dense
    known = Tracks.build(1, position=[[0, 0, 0]])
    assert cloud_from_rows(known, ROSBAGS_CLASSES, 'map').is_dense


def test_fields_of_earlier_versions_are_passed_over():
    """Feedback had a group, the cameras that see a target, and flags behind its columns."""
    rows = Feedback.build(1, position=[[1, 2, 0], [3, 4, 0]], track_id=[5, 6], previous_id=[0, 7])
    message = cloud_from_rows(rows, ROSBAGS_CLASSES, 'map')
    step, more = message.point_step, (('group', 6, 0), ('seen_by', 6, 4), ('flags', 2, 8))
    data = np.full((2, step + 12), 255, np.uint8)
    data[:, :step] = np.asarray(message.data).reshape(2, step)
    fields = [
        ROSBAGS_CLASSES.field(name=name, offset=step + offset, datatype=kind, count=1)
        for name, kind, offset in more
    ]
    message.fields = [*message.fields, *fields]
    message.point_step, message.row_step = step + 12, 2 * (step + 12)
    message.data = ROSBAGS_CLASSES.octets(data.reshape(-1))
    back = rows_from_cloud(message, Feedback)
    for name in rows.COLUMNS:
        np.testing.assert_array_equal(getattr(back, name), getattr(rows, name))


def test_a_detection_needs_a_position_and_a_score_alone():
    step, names = 16, ('x', 'y', 'z', 'score')
    fields = [
        ROSBAGS_CLASSES.field(name=name, offset=4 * k, datatype=7, count=1)
        for k, name in enumerate(names)
    ]
    data = np.array([[1, 2, 0, 0.5], [3, 4, 0, 0.75]], np.float32)
    message = broken(fields=fields, width=2, point_step=step, row_step=2 * step)
    message.data = data.view(np.uint8).reshape(-1)
    rows = rows_from_cloud(message, Detections)
    np.testing.assert_array_equal(rows.position, data[:, :3])
    np.testing.assert_array_equal(rows.score, data[:, 3])
    np.testing.assert_allclose(rows.covariance, np.array([np.eye(2)] * 2) * 0.09)
    assert np.isnan(rows.extent).all()
    assert rows.member_count.tolist() == [1, 1]
    assert not rows.template.any()
    assert usable_rows(rows).all()


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
        (broken(fields=fields_without('score')), "lacks the field 'score'"),
        (broken(fields=fields_with('box', datatype=8)), 'is 4 x f8, expected 4 x f4'),
        (broken(fields=fields_with('box', datatype=99)), 'is 4 x unknown'),
        (broken(fields=fields_with('box', count=2)), 'is 2 x f4, expected 4 x f4'),
        (broken(fields=fields_with('kit', offset=4000)), 'exceeds its point_step'),
        (broken(is_bigendian=True), 'big-endian'),
        (broken(width=2), 'a cloud of 2 Detections holds'),
        (broken(data=np.zeros(3, np.uint8)), 'holds 3 bytes'),
        (broken(point_step=0), 'exceeds its point_step'),
        (broken(fields=[*broken().fields, broken().fields[0]]), 'two fields of one name'),
        (broken(fields=fields_with('y', offset=2)), "fields 'x' and 'y' of a cloud of .* overlap"),
        (
            broken(height=2, row_step=9, data=np.tile(broken().data, 2)),
            'has the row_step 9, expected',
        ),
    ],
)
def test_wrong_clouds_are_refused_with_the_reason(message, reason):
    with pytest.raises(CodecError, match=reason):
        rows_from_cloud(message, Detections)


def test_a_refusal_is_one_short_line_whatever_the_message_holds():
    row = Detections.build(1, position=[[0, 0, 0]], template=[[np.inf] * 48])
    with pytest.raises(CodecError, match='template of row 0') as refusal:
        rows_from_cloud(cloud_from_rows(row, ROSBAGS_CLASSES, 'map'), Detections)
    assert len(str(refusal.value)) < 200
    named = SimpleNamespace(name='a\n' * 5000, offset=0, datatype=99, count=1)
    with pytest.raises(CodecError, match='unknown datatype') as refusal:
        fields_of_cloud(broken(fields=[named]))
    assert len(str(refusal.value)) < 200
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize('value', [np.nan, np.inf, -np.inf])
def test_numbers_that_must_be_finite_are(value):
    row = Detections.build(1, position=[[0, 0, 0]], score=[value])
    with pytest.raises(CodecError, match='score of row 0 is not finite'):
        rows_from_cloud(cloud_from_rows(row, ROSBAGS_CLASSES, 'map'), Detections)


def test_an_empty_cloud_of_huge_points_is_empty():
    message = broken(width=0, data=np.zeros(0, np.uint8), point_step=2**32 - 1)
    assert len(rows_from_cloud(message, Detections)) == 0


@pytest.mark.parametrize(
    'fields', [[*fields_with('box'), *fields_with('box')], fields_with('box', count=2**32 - 1)]
)
def test_fields_that_cannot_be_are_refused(fields):
    with pytest.raises(CodecError, match='fields that cannot be'):
        fields_of_cloud(broken(fields=fields))


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


def test_detections_need_only_what_a_detector_knows():
    known = {'x', 'y', 'z', 'covariance', 'box', 'area', 'score'}
    row = Detections.build(
        5, position=[[1, 2, 0]], covariance=[np.eye(2) * 0.04], box=[[3, 4, 20, 60]], score=[0.5]
    )
    written = cloud_from_rows(row, ROSBAGS_CLASSES, 'map')
    members = {name: getattr(written, name) for name in written.__dataclass_fields__}
    members['fields'] = [field for field in written.fields if field.name in known]
    read = rows_from_cloud(SimpleNamespace(**members), Detections)
    for name in Detections.COLUMNS:
        np.testing.assert_array_equal(getattr(read, name), getattr(row, name))


@pytest.mark.parametrize(
    ('rows', 'late'),
    [
        (Events.build(5, event=[3], local_id=[9]), 'other_tracks'),
        (Detections.build(5, position=[[1, 2, 0]], extent=[[0.6, 1.8]], local_id=[9]), 'extent'),
    ],
)
def test_a_field_that_came_later_may_be_absent(rows, late):
    written = cloud_from_rows(rows, ROSBAGS_CLASSES, 'map')
    fields = [field for field in written.fields if field.name != late]
    members = {name: getattr(written, name) for name in written.__dataclass_fields__}
    old = SimpleNamespace(**(members | {'fields': fields}))
    read = rows_from_cloud(old, type(rows))
    assert read.local_id.tolist() == [9]
    np.testing.assert_array_equal(
        getattr(read, late), getattr(type(rows).build(5, local_id=[9]), late)
    )
