import numpy as np

from mctrack_ros.fusion.columns import NEVER_NS
from mctrack_ros.fusion.management.manager import TrackManager
from mctrack_ros.fusion.table import TrackTable


def named(*ids):
    table = TrackTable.blank(len(ids), 3)
    table.track_id = ids
    return table


def test_of_blank_tracks_nothing_is_known():
    table = TrackTable.blank(2, 3)
    assert len(table) == 2
    assert (table.seen_by_ns == NEVER_NS).all()
    assert not table.covariance.any()
    assert table.seen_by_ns.shape == (2, 3)


def test_columns_are_changed_in_place_and_copied_by_selection():
    table = named(1, 2, 3)
    picked = table.select(np.array([True, False, True]))
    table.mean[0] = 7.0
    assert picked.track_id.tolist() == [1, 3]
    assert not picked.mean.any()
    assert table.mean[0].tolist() == [7.0] * 4


def test_tables_are_joined_one_after_the_other():
    one, none = named(1, 2), TrackTable.blank(0, 3)
    assert one.extended(named(5)).track_id.tolist() == [1, 2, 5]
    assert one.extended(none) is one
    assert len(none.extended(none)) == 0


def test_tracks_are_added_and_taken_out_where_the_table_lies():
    table, name = named(1, 2, 3), 4
    for _ in range(5):
        picked = table.remove(np.arange(len(table)) == 1)
        table.append(named(name, name + 1))
        name += 2
        assert len(picked) == 1
    assert table.track_id.tolist() == [1, 7, 8, 9, 10, 11, 12, 13]
    table.fixed['mean'][3] = 7.0
    assert table.mean[3].tolist() == [7.0] * 4
    assert (table.seen_by_ns == NEVER_NS).all()
    assert picked.track_id.tolist() == [6]
    assert table.remove(np.ones(8, bool)).track_id.tolist() == [1, 7, 8, 9, 10, 11, 12, 13]
    assert len(table) == 0


def test_renaming_exchanges_ids_and_remembers_the_old_ones():
    table = named(1, 2, 3)
    table.group = [1, 1, 0]
    order = TrackManager.rename(table, {1: 3, 3: 1})
    table = table.select(order)
    assert table.track_id.tolist() == [1, 2, 3]
    assert table.previous_id.tolist() == [3, 0, 1]
    assert table.group.tolist() == [0, 3, 3]
