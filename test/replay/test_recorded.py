"""What fusion was given comes out of a bag again."""

import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.fusion import JointConfig
from mctrack_ros.interfaces import Ticks
from mctrack_ros.recording import BagError, BagReader, BagWriter
from mctrack_ros.replay.recorded import recorded_ticks

CAMERAS = ('one', 'two')


def write(path, stamps, ticks=()):
    """Write detections, as (camera, period, offset in ns), and records of what was admitted."""
    with BagWriter(path) as bag:
        for number, (camera, period, offset_ns) in enumerate(stamps):
            rows = detections(period * PERIOD_NS + offset_ns, [[number, 0.0]])
            bag.write_rows(f'/{camera}/detections', rows, 'map', number)
        for stamp_ns, admitted in ticks:
            record = Ticks.build(stamp_ns, camera=np.arange(len(admitted)), admitted=admitted)
            bag.write_rows('/ticks', record, 'map', stamp_ns)
    return path


def given(path):
    """Return of each tick the stamp, and who gave what."""
    with BagReader(path) as reader:
        return [
            (
                tick.stamp_ns,
                [(each.camera, int(each.rows.position[0, 0])) for each in tick.messages],
            )
            for tick in recorded_ticks(reader, CAMERAS, JointConfig())
        ]


def test_without_a_record_all_is_sorted_into_periods(tmp_path):
    stamps = [('two', 5, 9), ('one', 5, 3), ('one', 6, 2), ('two', 7, 1)]
    assert given(write(tmp_path / 'bag', stamps)) == [
        (5 * PERIOD_NS + 9, [('one', 1), ('two', 0)]),
        (6 * PERIOD_NS + 2, [('one', 2)]),
        (7 * PERIOD_NS + 1, [('two', 3)]),
    ]


def test_time_that_begins_anew_goes_on_from_there(tmp_path):
    stamps = [('one', 500, 3), ('two', 500, 9), ('one', 5, 3), ('two', 5, 9)]
    assert given(write(tmp_path / 'bag', stamps)) == [
        (500 * PERIOD_NS + 9, [('one', 0), ('two', 1)]),
        (5 * PERIOD_NS + 9, [('one', 2), ('two', 3)]),
    ]


def test_what_came_late_is_left_out_as_it_was(tmp_path):
    stamps = [('one', 5, 3), ('one', 6, 2), ('two', 6, 2), ('two', 5, 9)]
    ticks = [(5 * PERIOD_NS + 3, [1, 0]), (6 * PERIOD_NS + 2, [1, 1])]
    assert given(write(tmp_path / 'bag', stamps, ticks)) == [
        (5 * PERIOD_NS + 3, [('one', 0)]),
        (6 * PERIOD_NS + 2, [('one', 1), ('two', 2)]),
    ]


def test_detections_that_were_fused_and_not_recorded_are_missed(tmp_path):
    path = write(tmp_path / 'bag', [('one', 5, 3)], [(5 * PERIOD_NS + 3, [1, 1])])
    with pytest.raises(BagError, match='lacks detections of two that were fused'):
        given(path)


def test_a_bag_of_more_cameras_than_the_site_has_is_refused(tmp_path):
    path = write(tmp_path / 'bag', [('one', 5, 3)], [(5 * PERIOD_NS + 3, [1, 0, 1])])
    with pytest.raises(BagError, match='more cameras than the site has: one, two'):
        given(path)


def test_a_bag_without_detections_is_refused(tmp_path):
    path = write(tmp_path / 'bag', [('three', 5, 3)])
    with pytest.raises(BagError, match='holds no detections of one, two: track it first'):
        given(path)
