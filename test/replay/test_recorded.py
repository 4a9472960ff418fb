"""What fusion was given comes out of a bag again."""

import numpy as np
import pytest

from fusion_scenes import PERIOD_NS, detections
from mctrack_ros.fusion import JointConfig, open_batcher
from mctrack_ros.fusion.camera_clocks import Verdict
from mctrack_ros.interfaces import Ticks
from mctrack_ros.recording import BagError, BagReader, BagWriter
from mctrack_ros.replay.recorded import recorded_ticks

CAMERAS = ('one', 'two')


def write(path, stamps, ticks=(), broken=None):
    """Write detections, as (camera, period, offset in ns), and records of what was admitted."""
    with BagWriter(path) as bag:
        if broken is not None:
            bag.write_rows('/one/detections', broken, 'map', 0)
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


def test_what_the_fusion_node_refused_is_passed_over_if_it_is_known_what_was_admitted(tmp_path):
    broken = detections(5 * PERIOD_NS + 4, [[np.inf, 0.0]])
    for name, ticks in (('ticks', [(5 * PERIOD_NS + 3, [1, 1])]), ('none', ())):
        stamps = [('one', 5, 3), ('two', 5, 9)]
        path = write(tmp_path / name, stamps, ticks, broken)
        if ticks:
            assert given(path) == [(5 * PERIOD_NS + 3, [('one', 0), ('two', 1)])]
        else:
            with pytest.raises(BagError, match='position of row 0 is not finite'):
                given(path)


def test_a_bag_of_more_cameras_than_the_site_has_is_refused(tmp_path):
    path = write(tmp_path / 'bag', [('one', 5, 3)], [(5 * PERIOD_NS + 3, [1, 0, 1])])
    with pytest.raises(BagError, match='more cameras than the site has: one, two'):
        given(path)


def test_a_bag_without_detections_is_refused(tmp_path):
    path = write(tmp_path / 'bag', [('three', 5, 3)])
    with pytest.raises(BagError, match='holds no detections of one, two: track it first'):
        given(path)


def test_a_clock_that_is_set_right_within_a_tick_is_repeated(tmp_path):
    """Live, a batcher adds 60 ms to the stamp of one message, and nothing to that of the next."""
    config = JointConfig()
    batcher = open_batcher(config, CAMERAS)
    added_ns = iter([60_000_000, 0, 0])
    batcher.clocks.judge = lambda *_: Verdict(next(added_ns), 0, True, 0)
    stamps = [('one', 8, 5_000_000), ('one', 9, 30_000_000), ('two', 9, 10_000_000)]
    with BagWriter(tmp_path / 'bag') as bag:
        ticks = []
        for number, (camera, period, offset_ns) in enumerate(stamps):
            rows = detections(period * PERIOD_NS + offset_ns, [[number, 0.0]])
            bag.write_rows(f'/{camera}/detections', rows, 'map', number)
            ticks += batcher.add(camera, rows, 1000, rows.stamp_ns)
        (tick,) = ticks + batcher.flush()
        bag.write_rows('/ticks', tick.record, 'map', 9)
    assert tick.record.camera.tolist() == [0, 1, 0]
    assert tick.record.admitted.tolist() == [1, 1, 1]
    assert tick.record.added_ms.tolist() == [60, 0, 0]
    assert tick.record.missing.tolist() == [0, 0, 0]
    live = [(each.camera, each.rows.stamp_ns) for each in tick.messages]
    with BagReader(tmp_path / 'bag') as reader:
        (again,) = recorded_ticks(reader, CAMERAS, config)
    assert [(each.camera, each.rows.stamp_ns) for each in again.messages] == live
    assert given(tmp_path / 'bag') == [(tick.stamp_ns, [('one', 0), ('one', 1), ('two', 2)])]
