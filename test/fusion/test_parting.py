from dataclasses import replace

import numpy as np
import pytest
from fusion_scenes import published, tick

from mctrack_ros.fusion import FusionConfig, FusionPipeline
from mctrack_ros.fusion.parting import LATELY_S, go_on_as, parted
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import EventCode, TrackStatus

SECOND_NS = 1_000_000_000
STAMP_NS = 100 * SECOND_NS
CAMERAS = ('one', 'two')
DEFAULT = FusionConfig()
JPDA = replace(DEFAULT, association=replace(DEFAULT.association, method='jpda'))


def tracks(beside=8, age_s=1.0, confirmed=(True, True, True)):
    """Return tracks 7 and 8 in one place, and 9, which began beside one of them."""
    table = TrackTable.blank(3, 2)
    table.track_id, table.confirmed = [7, 8, 9], confirmed
    table.mean[2, :2] = [1.5, 0.0]
    table.first_ns = [0, SECOND_NS, STAMP_NS - round(age_s * 1e9)]
    table.beside[2] = beside
    return table


def test_a_new_track_beside_two_that_seem_one_is_the_one_that_it_began_beside():
    assert parted(tracks(beside=8), [(7, 8)], STAMP_NS) == [(1, 2)]
    assert parted(tracks(beside=7), [(7, 8)], STAMP_NS) == [(0, 2)]


@pytest.mark.parametrize(
    ('doubtful', 'how'),
    [
        ([], {}),
        ([(7, 8)], {'beside': 0}),
        ([(7, 8)], {'beside': 5}),
        ([(7, 8)], {'age_s': LATELY_S}),
        ([(7, 8)], {'confirmed': (True, True, False)}),
        ([(7, 8)], {'confirmed': (True, False, True)}),
        ([(8, 9)], {}),  # it is one of the two itself
        ([(6, 8)], {}),  # there is no 6 any more
    ],
)
def test_it_is_nobody_who_was_there_unless_all_are_sure_and_it_is_new(doubtful, how):
    assert parted(tracks(**how), doubtful, STAMP_NS) == []


def test_nobody_goes_on_as_two():
    table = tracks()
    table.append(table.select(np.array([2])))
    table.track_id[3] = 10
    assert parted(table, [(7, 8)], STAMP_NS) == [(1, 2)]


def test_who_goes_on_keeps_name_and_age_and_is_elsewhere():
    table = tracks()
    go_on_as(table, 1, 2)
    assert table.track_id.tolist() == [7, 8, 9]
    assert table.first_ns[1] == SECOND_NS
    assert table.mean[1].tolist() == table.mean[2].tolist()
    assert (table.previous_id[1], table.beside[1]) == (9, 0)


def parting(index):
    """Two meet; from 4 s on each camera has one detection of both, from 5 s on one has left."""
    x = index * 0.04
    place, beside = [x, 0.0], [x, 0.15 + 0.05 * max(100 - index, 0)]
    if index < 100:
        return {name: [place, beside] for name in CAMERAS}
    gone = [[x, 1.6]] if index >= 125 else []
    return {'one': [place, *gone], 'two': [beside, *gone]}


def test_who_parts_from_another_keeps_his_id():
    pipeline = FusionPipeline(JPDA, CAMERAS)
    outputs = [pipeline.step(tick(index, parting(index))) for index in range(190)]
    before, after = published(outputs[99]), published(outputs[-1])
    assert len(before) == 2
    assert sorted(after) == sorted(before)
    events = [out.events for out in outputs[100:] if EventCode.CORRECTION in out.events.event]
    (correction,) = [rows.select(rows.event == EventCode.CORRECTION) for rows in events]
    assert correction.new_id[0] in before
    assert correction.old_id[0] not in before
    np.testing.assert_allclose(after[int(correction.new_id[0])], parting(189)['one'][1], atol=0.3)
    ended = [out.tracks.track_id[out.tracks.status == TrackStatus.DELETED] for out in outputs]
    assert not before.keys() & set(np.concatenate(ended).tolist())
