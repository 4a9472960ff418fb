import pickle

import numpy as np
import pytest

from mctrack_ros.interfaces import Detections, Rows, Tracks, code_tables


def test_missing_columns_take_their_defaults():
    rows = Detections.build(7, position=[[1, 2, 0], [3, 4, 0]])
    assert len(rows) == 2
    assert rows.member_count.tolist() == [1, 1]
    assert rows.score.tolist() == [1.0, 1.0]
    assert rows.covariance.shape == (2, 2, 2)


def test_empty_rows_carry_every_column():
    rows = Tracks.build(7)
    assert len(rows) == 0
    assert rows.covariance.shape == (0, 4, 4)
    assert rows.covariance.dtype == np.float32


def test_unknown_column_is_refused():
    with pytest.raises(ValueError, match="no column 'colour'"):
        Tracks.build(7, colour=[1])


def test_wrong_shape_is_refused_with_both_shapes():
    with pytest.raises(ValueError, match=r'box has shape \(1, 3\).*expected \(1, 4\)'):
        Detections.build(7, position=[[0, 0, 0]], box=[[1, 2, 3]])


def test_columns_of_different_lengths_are_refused():
    with pytest.raises(ValueError, match='track_id'):
        Tracks.build(7, position=[[0, 0, 0]], track_id=[1, 2])


def test_arrays_are_read_only_and_the_givers_array_is_not_touched():
    given = np.zeros((1, 3), np.float32)
    rows = Detections.build(7, position=given)
    with pytest.raises(ValueError, match='read-only'):
        rows.position[0, 0] = 1
    given[0, 0] = 1


def test_select_and_replace_keep_the_other_columns():
    rows = Tracks.build(7, position=np.arange(9).reshape(3, 3), track_id=[5, 6, 7])
    picked = rows.select(np.array([2, 0])).replace(score=[0.5, 0.25])
    assert picked.track_id.tolist() == [7, 5]
    assert picked.score.tolist() == [0.5, 0.25]
    assert picked.stamp_ns == 7


@pytest.mark.parametrize('count', [0, 3])
def test_rows_survive_pickling(count):
    rows = Tracks.build(7, position=np.arange(3.0 * count).reshape(count, 3))
    copy = pickle.loads(pickle.dumps(rows))
    assert copy.stamp_ns == 7
    for name, column in Tracks.COLUMNS.items():
        array = getattr(copy, name)
        assert array.dtype == column.dtype
        assert array.tobytes() == getattr(rows, name).tobytes()
        assert not array.flags.writeable


def test_every_row_type_begins_with_the_position():
    for kind in Rows.__subclasses__():
        assert next(iter(kind.COLUMNS)) == 'position'


def test_code_tables_name_every_code():
    assert code_tables()['TrackStatus']['DELETED'] == 4
    assert code_tables()['EventCode']['MERGE'] == 5


def test_joined_rows_follow_one_another_under_one_stamp():
    parts = [
        Detections.build(stamp, score=score) for stamp, score in ((1, [0.5]), (2, [0.1, 0.2]))
    ]
    joined = Detections.joined(3, parts)
    assert joined.stamp_ns == 3
    np.testing.assert_array_equal(joined.score, np.float32([0.5, 0.1, 0.2]))
    assert joined.template.shape == (3, 48)
    assert len(Detections.joined(3, [])) == 0
