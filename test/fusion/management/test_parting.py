from dataclasses import replace

import numpy as np
import pytest

from fusion_scenes import published, tick
from mctrack_ros.fusion import JointConfig, JointTracker
from mctrack_ros.fusion.management.duplicates import Doubt
from mctrack_ros.fusion.management.initiation import note_beside
from mctrack_ros.fusion.management.parting import LATELY_S, SOON_S, go_on_as, parted
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import EventCode, TrackStatus

SECOND_NS = 1_000_000_000
STAMP_NS = 100 * SECOND_NS
CAMERAS = ('one', 'two')
DEFAULT = JointConfig()
JPDA = replace(DEFAULT, association=replace(DEFAULT.association, method='jpda'))


def tracks(beside=8, age_s=1.0, confirmed=(True, True, True)):
    """Return tracks 7 and 8 in one place, and 9, which began beside one of them."""
    table = TrackTable.blank(3, 2)
    table.track_id, table.confirmed = [7, 8, 9], confirmed
    table.mean[2, :2] = [1.5, 0.0]
    table.first_ns = [0, SECOND_NS, STAMP_NS - round(age_s * 1e9)]
    table.beside[2] = beside
    return table


def doubts(*pairs, began_s=98.0):
    return {pair: Doubt(0.5, round(began_s * 1e9), reported=False) for pair in pairs}


def test_a_new_track_beside_two_that_seem_one_is_the_one_that_it_began_beside():
    assert parted(tracks(beside=8), doubts((7, 8)), (), STAMP_NS) == [(1, 2)]
    assert parted(tracks(beside=7), doubts((7, 8)), (), STAMP_NS) == [(0, 2)]
    table = tracks(beside=1)
    table.track_id[0] = 1
    assert parted(table, doubts((1, 8)), (), STAMP_NS) == [(0, 2)]


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
    assert parted(tracks(**how), doubts(*doubtful), (), STAMP_NS) == []


def test_two_who_come_near_each_other_later_were_two_when_it_began():
    table = tracks(age_s=1.0)
    soon, later = (doubts((7, 8), began_s=99.0 + SOON_S + wait) for wait in (-0.01, 0.01))
    assert parted(table, soon, (), STAMP_NS) == [(1, 2)]
    assert parted(table, later, (), STAMP_NS) == []


def test_nobody_goes_on_as_two():
    table = tracks()
    table.append(table.select(np.array([2])))
    table.track_id[3] = 10
    assert parted(table, doubts((7, 8)), (), STAMP_NS) == [(1, 2)]
    assert parted(table, doubts((7, 8)), {0}, STAMP_NS) == []


def test_who_goes_on_keeps_name_and_age_and_is_elsewhere():
    table = tracks()
    go_on_as(table, 1, 2)
    assert table.track_id.tolist() == [7, 8, 9]
    assert table.first_ns[1] == SECOND_NS
    assert table.mean[1].tolist() == table.mean[2].tolist()
    assert (table.previous_id[1], table.beside[1]) == (9, 0)


def test_what_is_not_known_of_the_new_one_stays_and_its_name_is_forgotten():
    table = tracks()
    table.template[1], table.extent[1] = 0.5, [0.6, 1.8]
    table.group[0] = table.beside[0] = 9
    go_on_as(table, 1, 2)
    assert (table.template[1] == 0.5).all()
    np.testing.assert_allclose(table.extent[1], [0.6, 1.8])
    assert (table.group[0], table.beside[0]) == (8, 8)


@pytest.mark.parametrize(('away', 'beside'), [(1.9, 8), (2.1, 0)])
def test_new_tracks_know_beside_which_confirmed_one_they_began(away, beside):
    table = tracks(confirmed=(False, True, True))
    table.mean[2, :2] = [30.0, 30.0]
    fresh = TrackTable.blank(1, 2)
    fresh.mean[0, 0] = away
    note_beside(fresh, table, DEFAULT)
    assert fresh.beside.tolist() == [beside]


def parting(index):
    """Two meet; from 4 s on each camera has one detection of both, from 5 s on one has left."""
    x = index * 0.04
    place, beside = [x, 0.0], [x, 0.15 + 0.05 * max(100 - index, 0)]
    if index < 100:
        return {name: [place, beside] for name in CAMERAS}
    gone = [[x, 1.6]] if index >= 125 else []
    return {'one': [place, *gone], 'two': [beside, *gone]}


def test_who_parts_from_another_keeps_his_id():
    pipeline = JointTracker(JPDA, CAMERAS)
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


def newcomer(index):
    """Two come to stand in one place long after a third began beside one of them."""
    place, other = [0.0, 0.0], [min(-0.1, -1.5 + 0.1 * max(index - 100, 0)), 0.0]
    new = [[0.0, 1.6]] if index >= 100 else []
    if index < 120:
        return {name: [place, other, *new] for name in CAMERAS}
    return {'one': [place, *new], 'two': [other, *new]}


@pytest.mark.parametrize('config', [DEFAULT, JPDA])
def test_who_came_before_two_seemed_one_keeps_his_id_too(config):
    pipeline = JointTracker(config, CAMERAS)
    outputs = [pipeline.step(tick(index, newcomer(index))) for index in range(150)]
    before, after = published(outputs[118]), published(outputs[145])
    assert len(before) == 3
    (new,) = before.keys() - published(outputs[99]).keys()
    np.testing.assert_allclose(after[new], [0.0, 1.6], atol=0.2)
