import numpy as np
import pytest

from mctrack_experiments.papers.silhouettes.activity import ActivityTable, wilson_interval

PEDESTRIANS = ActivityTable(np.array([[0, 9, 1, 0], [3, 120, 27, 2], [0, 3, 4, 0], [0, 0, 1, 1]]))
VEHICLES = ActivityTable(np.array([[0, 0, 0, 0], [0, 139, 1, 0]]))


def test_the_papers_own_table_gives_its_own_rates():
    events, perfect = (
        sum(getattr(table, name) for table in (PEDESTRIANS, VEHICLES))
        for name in ('events', 'perfect')
    )
    assert (perfect, events) == (264, 311)
    assert PEDESTRIANS.passed == (125, 132)


def test_over_tracked_lost_and_false_events_are_counted_apart():
    assert PEDESTRIANS.over_tracked == 27 + 2
    assert PEDESTRIANS.lost == 3 + 3 + 1
    assert PEDESTRIANS.false == 9 + 1
    parts = PEDESTRIANS.perfect + PEDESTRIANS.over_tracked + PEDESTRIANS.lost + PEDESTRIANS.false
    assert parts == PEDESTRIANS.events == 171


def test_events_fill_the_cell_of_their_true_and_tracked_numbers():
    table = ActivityTable.of([(1, 1), (1, 1), (1, 3), (2, 0), (0, 1)])
    np.testing.assert_array_equal(table.counts, [[0, 1, 0, 0], [0, 2, 0, 1], [1, 0, 0, 0]])
    assert ActivityTable.of([]).events == 0


def test_tables_of_different_sizes_add_up():
    total = PEDESTRIANS + VEHICLES
    assert total.events == 311
    assert total.counts[1].tolist() == [3, 259, 28, 2]


def test_many_columns_are_printed_as_one():
    text = ActivityTable.of([(1, 1), (1, 9), (1, 5)]).text()
    assert text.splitlines()[0].split() == ['0', '1', '2', '3', '4', '5+']
    assert text.splitlines()[2].split() == ['1', '0', '1', '0', '0', '0', '2']


def test_nothing_cannot_have_happened():
    with pytest.raises(ValueError, match='nothing was'):
        ActivityTable.of([(0, 0)])


def test_wilson_interval_of_the_papers_rates():
    assert wilson_interval(264, 311) == pytest.approx((0.8049, 0.8845), abs=1e-3)
    assert wilson_interval(0, 0) == (0.0, 1.0)
    low, high = wilson_interval(10, 10)
    assert low == pytest.approx(0.7225, abs=1e-3)
    assert high == pytest.approx(1.0)
