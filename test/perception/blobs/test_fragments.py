import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.perception.blobs.fragments import joined, trimmed
from mctrack_ros.perception.geometry.person_size import SizeTable

USUAL = 0.6, 1.75


@settings(deadline=None)
@given(st.integers(0, 2**32), st.floats(0.0, 1.0))
def test_trimmed_box_holds_what_differs_clearly(seed, share):
    rng = np.random.default_rng(seed)
    mask = np.where(rng.random((12, 15)) < 0.3, 255, 0).astype(np.uint8)
    difference = rng.integers(0, 255, mask.shape, np.uint8)
    box = np.array([[2.0, 1.0, 9.0, 8.0], [10.0, 9.0, 20.0, 20.0]])
    for row, (left, top, width, height) in zip(trimmed(mask, difference, box, share), box):
        inside = np.zeros(mask.shape, bool)
        inside[int(top) : int(top + height), int(left) : int(left + width)] = True
        inside &= mask > 0
        clear = inside & (difference > share * (difference[inside].mean() if inside.any() else 0))
        if not clear.any():
            assert not row.any()
            continue
        y, x = np.nonzero(clear)
        expected = [x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1]
        assert row[:4].tolist() == expected
        part = np.s_[y.min() : y.max() + 1, x.min() : x.max() + 1]
        assert row[4] == (mask[part] > 0).sum()


def test_three_fragments_of_one_person_become_one(mapping):
    sizes = SizeTable(mapping)
    foot = mapping.image_from_ground([[0.0, 0.0]])
    left, top, width, height = sizes.box_of(foot, np.array([[0.6, 1.75]]))[0]
    parts = [(0.0, 0.3), (0.35, 0.3), (0.7, 0.3)]
    box = np.array([[left, top + at * height, width, share * height] for at, share in parts])
    whole = joined(box, sizes.table, *USUAL)
    assert np.allclose(whole, [[left, top, width, height]])


def test_what_is_above_the_horizon_is_left_alone(mapping):
    sizes = SizeTable(mapping)
    sizes.table[:] = np.nan
    box = np.array([[10.0, 10.0, 5.0, 5.0], [10.0, 16.0, 5.0, 5.0]])
    assert np.array_equal(joined(box, sizes.table, *USUAL), box)


@pytest.mark.parametrize('count', [0, 1])
def test_nothing_to_join(mapping, count):
    box = np.full((count, 4), 5.0)
    assert np.array_equal(joined(box, SizeTable(mapping).table, *USUAL), box)
