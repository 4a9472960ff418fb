"""Queries answer the same as brute force over all rows, in both back ends."""

import csv
import io
import itertools
import json
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest

from command_line import mctrack
from mctrack_ros.interfaces import EventCode, Events, Tracks
from mctrack_ros.store import (
    Database,
    NewRun,
    Run,
    StoreError,
    TrajectoryWriter,
    VideoFile,
    View,
    crossings,
    events,
    heat_map,
    link_videos,
    meetings,
    near,
    occupancy,
    showings,
    summaries,
    trajectory,
)
from mctrack_ros.store.queries import areas, identities
from mctrack_ros.store.queries.results import Group
from mctrack_ros.store.queries.tracks import track_ids
from mctrack_ros.zones.engine import ZoneEngine
from mctrack_ros.zones.shapes import Line, Zone, Zones

BEGAN_NS = 1_700_000_000_000_000_000
TICK_S = 0.1


def tick(k, places, **columns):
    position = [(x, y, 0.0) for x, y in places.values()]
    stamp_ns = BEGAN_NS + k * 100_000_000
    return Tracks.build(stamp_ns, track_id=list(places), position=position, **columns)


def correction(k, *pairs):
    old, new = zip(*pairs)
    return Events.build(
        BEGAN_NS + k * 100_000_000,
        event=[EventCode.CORRECTION] * len(pairs),
        track_id=new,
        old_id=old,
        new_id=new,
    )


def write(database, ticks, happenings=(), **run):
    """Write ticks, and events in their ticks."""
    by_stamp = {each.stamp_ns: each for each in happenings}
    with TrajectoryWriter(database, NewRun(**{'name': 'a', **run})) as writer:
        for rows in ticks:
            writer.write_tracks(rows)
            if rows.stamp_ns in by_stamp:
                writer.write_events(by_stamp[rows.stamp_ns])


@pytest.fixture
def crowd(database):
    """Twelve people who walk at random for a minute and a half."""
    random = np.random.default_rng(5)
    place = random.uniform(5, 15, (12, 2))
    walk = np.cumsum(random.normal(0, 0.08, (900, 12, 2)), axis=0) + place
    walk = walk.astype(np.float32).astype(float)
    write(database, [tick(k, dict(enumerate(each.tolist(), 1))) for k, each in enumerate(walk)])
    with Run(database) as run:
        yield run, walk


def episodes_of(is_near):
    """Return first and last tick of each stretch, pauses of a second bridged."""
    found = []
    for k in np.flatnonzero(is_near).tolist():
        if found and k - found[-1][1] <= 10:
            found[-1][1] = k
        else:
            found.append([k, k])
    return found


def test_who_was_near_a_track(crowd):
    run, walk = crowd
    inside = slice(200, 800)
    expected = set()
    for other in range(12):
        distance = np.hypot(*(walk[:, other] - walk[:, 3]).T)[inside]
        if other != 3:
            for first, last in episodes_of(distance <= 2):
                expected.add((other + 1, 20 + first / 10, 20 + last / 10))
    found = near(run, 4, 2.0, (20.0, 80.0))
    assert {(each.track_id, each.began_s, each.ended_s) for each in found} == expected
    assert len(expected) > 3
    best = found[0]
    k = round(best.closest_s * 10)
    assert best.closest_m == pytest.approx(np.hypot(*(walk[k, best.track_id - 1] - walk[k, 3])))


def test_who_was_near_a_point(crowd):
    run, walk = crowd
    expected = {
        (other + 1, first / 10, last / 10)
        for other in range(12)
        for first, last in episodes_of(np.hypot(*(walk[:, other] - [10, 10]).T) <= 3)
    }
    found = near(run, (10.0, 10.0), 3.0)
    assert {(each.track_id, each.began_s, each.ended_s) for each in found} == expected != set()


def test_who_met_whom(crowd):
    run, walk = crowd
    expected = {
        (one + 1, other + 1, first / 10, last / 10)
        for one, other in itertools.combinations(range(12), 2)
        for first, last in episodes_of(np.hypot(*(walk[:, one] - walk[:, other]).T) <= 1.5)
        if last - first >= 10
    }
    found = {
        (each.track_id, each.other_id, each.began_s, each.ended_s)
        for each in meetings(run, least_s=1.0)
    }
    assert found == expected != set()
    assert any(began < 60 <= ended for _, _, began, ended in expected)


def test_counts_in_an_area_and_heat(crowd):
    run, walk = crowd
    area = [(5, 5), (15, 5), (15, 15), (5, 15)]
    inside = ((walk >= 5) & (walk <= 15)).all(axis=2)
    found = occupancy(run, area, (0.0, 90.0), per_s=30.0)
    assert [each.began_s for each in found] == [0.0, 30.0, 60.0]
    for period, each in enumerate(found):
        part = inside[period * 300 : period * 300 + 300]
        assert each.visitors == part.any(axis=0).sum()
        assert each.most == part.sum(axis=1).max()
        assert each.mean == pytest.approx(part.sum(axis=1).mean(), rel=0.1)
    cells = heat_map(run, cell_m=2.0)
    assert sum(each.seconds for each in cells) == pytest.approx(12 * 89.9)


def test_crossings_of_a_line(database):
    ticks = []
    for k in range(100):
        there, back = (k * 0.1, 5.0), (9.9 - k * 0.1, 5.0)
        ticks.append(tick(k, {1: there, 2: back, 3: (k * 0.1, 15.0)}))
    write(database, ticks)
    with Run(database) as run:
        found = crossings(run, [(5.05, 0.0), (5.05, 10.0)], (0.0, 10.0), per_s=10.0)
    assert [(each.to_left, each.to_right) for each in found] == [(1, 1)]


DOOR = Line('door', ((0.0, -5.0), (0.0, 5.0)))
ROOM = Zone('room', ((0.0, -5.0), (9.0, -5.0), (9.0, 5.0), (0.0, 5.0)), dwell_s=1.0)
SITE = Zones((ROOM,), (DOOR,))


def live(database, ticks, happenings=(), **run):
    """Write ticks as the fusion node publishes them, zone events too; return these."""
    by_stamp = {each.stamp_ns: each for each in happenings}
    engine, told = ZoneEngine(SITE), []
    with TrajectoryWriter(database, NewRun(**{'name': 'a', **run})) as writer:
        writer.write_description(json.dumps({'zones': SITE.described()}), BEGAN_NS)
        for rows in ticks:
            writer.write_tracks(rows)
            happened = by_stamp.get(rows.stamp_ns, Events.build(rows.stamp_ns))
            events_ = engine.added(rows, happened)
            if len(events_):
                writer.write_events(events_)
            told.append(events_)
    return Events.joined(BEGAN_NS, told)


def jittering():
    """Five walk to and fro at the door, with the noise that their covariance says."""
    random = np.random.default_rng(3)
    for k in range(900):
        x = 1.5 * np.sin(k * 0.02 + np.arange(5)) + random.normal(0, 0.1, 5)
        covariance = np.tile(np.diag([0.01, 0.01, 1, 1]), (5, 1, 1))
        places = {name: (float(each), 0.5 * name) for name, each in enumerate(x, 1)}
        yield tick(k, places, covariance=covariance)


def count_of(told, *codes):
    return int(np.isin(told.event, codes).sum())


def test_the_database_counts_what_was_told_live(database):
    """Nothing was corrected: the same numbers, of named zones and lines as of their points."""
    told = live(database, jittering())
    ways = count_of(told, EventCode.CROSS_LEFT), count_of(told, EventCode.CROSS_RIGHT)
    assert 25 <= sum(ways) <= 30  # they come to the middle 5.7 times each; raw signs: over 80
    with Run(database) as run:
        assert run.zones() == SITE
        (found,) = crossings(run, run.zones().lines[0], (0.0, 90.0), per_s=90.0)
        assert (found.to_left, found.to_right) == ways
        halves = crossings(run, DOOR.points, (0.0, 90.0), per_s=45.0)
        assert sum(each.to_left + each.to_right for each in halves) == sum(ways)
        (late,) = crossings(run, DOOR.points, (45.0, 90.0), per_s=45.0)
        assert late == halves[1]
        (inside,) = occupancy(run, run.zones().zones[0], (0.0, 90.0), per_s=90.0)
        assert inside.entered == count_of(told, EventCode.ENTER_ZONE) >= ways[1]
        assert inside.left == count_of(told, EventCode.LEAVE_ZONE)
        counts = told.new_id[told.event == EventCode.OCCUPANCY]
        assert inside.most == counts.max()
        assert inside.visitors == 5
        stored = events(run, [EventCode.CROSS_RIGHT])
        assert len(stored) == ways[1]
        assert {each.zone for each in stored} == {'door'}
        assert {each.zone for each in events(run, [EventCode.DWELL])} == {'room'}


@pytest.mark.parametrize('text', ['no', '[]', '{"zones": 5}', '{"zones": [{"kind": "zone"}]}'])
def test_another_programs_description_names_no_zones(database, text):
    with TrajectoryWriter(database, NewRun('a')) as writer:
        writer.write_description(text, BEGAN_NS)
        writer.write_tracks(tick(0, {1: (0.0, 0.0)}))
    with Run(database) as run:
        assert run.zones() == Zones()


def test_a_long_run_is_answered_window_by_window(database, monkeypatch):
    """The windows are as long as the look-back: everybody is inside across some of them."""
    told = live(database, jittering())
    with Run(database) as run:
        whole = crossings(run, DOOR, per_s=9.0), occupancy(run, ROOM, per_s=9.0)
        monkeypatch.setattr(areas, '_WINDOW_S', 4.0)
        monkeypatch.setattr(areas, '_LOOK_BACK_S', 4.0)
        assert (crossings(run, DOOR, per_s=9.0), occupancy(run, ROOM, per_s=9.0)) == whole
    entered = count_of(told, EventCode.ENTER_ZONE)
    assert sum(each.entered for each in whole[1]) == entered
    assert sum(each.visitors for each in whole[1]) > entered


def test_counts_follow_corrections_back(database):
    """One track ends on the line; the other, that begins beyond it, turns out to be the same."""
    ticks = [tick(k, {1: (k * 0.1 - 2.0, 0.0)}) for k in range(19)]
    ticks += [tick(k, {}) for k in range(19, 40)]
    ticks += [tick(k, {5 if k < 60 else 1: (0.5 + (k - 40) * 0.05, 0.0)}) for k in range(40, 80)]
    told = live(database, ticks, [correction(60, (5, 1))])
    assert count_of(told, EventCode.CROSS_RIGHT) == 1
    assert told.track_id[told.event == EventCode.CROSS_RIGHT].tolist() == [1]
    with Run(database) as run:
        found = crossings(run, DOOR, (0.0, 8.0), per_s=2.0)
        (inside,) = occupancy(run, ROOM, (0.0, 8.0), per_s=8.0)
    assert [(each.to_left, each.to_right) for each in found] == [(0, 0), (0, 0), (0, 1), (0, 0)]
    assert (inside.visitors, inside.entered, inside.most) == (1, 1, 1)
    with Run(database, view=View(corrected=False)) as run:
        found = crossings(run, DOOR, (0.0, 8.0), per_s=2.0)
    assert [each.to_right for each in found] == [0, 0, 0, 1]


def test_who_walks_around_a_line_far_from_it_does_not_cross_it(database):
    """Chunks far from the line are not those that are looked for, yet are on the way."""
    corners = np.array([(-1, 0), (-1, 40), (40, 40), (1, 0)], float)
    path = np.concatenate([np.linspace(a, b, 60) for a, b in itertools.pairwise(corners)])
    write(database, [tick(k, {1: tuple(place)}) for k, place in enumerate(path.tolist())])
    with Run(database) as run:
        found = crossings(run, DOOR)
    assert sum(each.to_left + each.to_right for each in found) == 0


def swapped():
    """Two meet at 5 s and are exchanged by the tracker; it notices at 8 s."""
    for k in range(120):
        x = k * 0.1
        first, second = (x, 0.5 * (x > 5)), (10 - x, -0.5 * (x < 5))
        names = (1, 2) if k < 50 or k >= 80 else (2, 1)
        yield tick(k, dict(zip(names, (first, second))))


def test_corrections_apply_back_to_where_two_met(database):
    write(database, swapped(), [correction(80, (1, 2), (2, 1))])
    with Run(database) as run:
        places = trajectory(run, 1)
        assert [round(each.x, 3) for each in places] == pytest.approx(np.arange(120) * 0.1)
        assert {each.reported_id for each in places} == {1, 2}
        corrected = identities.corrections(run)
        assert [(each.old_id, each.new_id, each.time_s) for each in corrected] == [
            (1, 2, 8.0),
            (2, 1, 8.0),
        ]
        assert all(each.since_s < 8.0 for each in corrected)
        assert identities.corrections(run, (0.0, 8.0)) == []
    with Run(database, view=View(as_of_s=7.0)) as run:
        places = trajectory(run, 1)
        assert places[-1].time_s == 7.0
        assert places[-1].x == pytest.approx(3.0)
    with Run(database, view=View(corrected=False)) as run:
        assert {each.reported_id for each in trajectory(run, 1)} == {1}
        assert trajectory(run, 1)[60].x == pytest.approx(4.0)


def test_who_is_recognised_has_one_life(database):
    ticks = [tick(k, {1 if k < 30 else 7 if k < 60 else 1: (k * 0.1, 0)}) for k in range(90)]
    write(database, ticks, [correction(60, (7, 1))])
    with Run(database) as run:
        assert len(trajectory(run, 1)) == 90
        assert trajectory(run, 7) == []
        assert [each.track_id for each in summaries(run)] == [1]
        assert summaries(run)[0].mean_mps == pytest.approx(1.0, rel=0.01)
        assert summaries(run)[0].distance_m == pytest.approx(8.9, rel=0.01)


def test_two_tracks_of_one_person_are_one_life(database):
    ticks = []
    for k in range(60):
        places = {1: (k * 0.1, 0)} | ({2: (k * 0.1, 0.3)} if 20 <= k < 40 else {})
        ticks.append(tick(k, places))
    write(database, ticks, [correction(40, (2, 1))])
    with Run(database) as run:
        assert [each.reported_id for each in trajectory(run, 1)] == [1] * 60
        assert meetings(run) == []


def test_events_are_found_by_kind_area_and_person(database):
    happened = Events.build(
        BEGAN_NS + 10**9,
        event=[EventCode.NEW, EventCode.EXIT, EventCode.NEW],
        track_id=[7, 2, 3],
        position=[(1, 1, 0), (2, 2, 0), (9, 9, 0)],
        probability=[0.5, 0.25, 1.0],
    )
    ticks = [tick(k, {7 if k < 20 else 1: (0, 0)}) for k in range(40)]
    write(database, ticks, [happened, correction(20, (7, 1))])
    area = [(0, 0), (4, 0), (4, 4), (0, 4)]
    with Run(database) as run:
        assert [each.track_id for each in events(run, [EventCode.NEW])] == [1, 3]
        found = events(run, [EventCode.NEW], area)
        assert [(each.track_id, each.reported_id, each.x) for each in found] == [(1, 7, 1.0)]
        assert [each.event for each in events(run, track=1)] == ['new', 'correction']
        assert events(run, between=(1.5, 9.0), kinds=[EventCode.NEW]) == []


def test_groups_have_members_from_when_to_when(database):
    ticks = [
        tick(k, {1: (0, 0), 2: (0, 1)}, group=[5 if 10 <= k < 70 else 0, 5 if k > 40 else 0])
        for k in range(100)
    ]
    write(database, ticks)
    with database.connected() as connection:
        members = connection.exec_driver_sql(
            'SELECT group_id, track_id, began_ns, ended_ns FROM group_members ORDER BY track_id'
        ).all()
        groups = connection.exec_driver_sql('SELECT began_ns, ended_ns FROM groups').all()
    seconds = [(g, t, (b - BEGAN_NS) / 1e9, (e - BEGAN_NS) / 1e9) for g, t, b, e in members]
    assert seconds == [(5, 1, 1.0, 6.9), (5, 2, 4.1, 9.9)]
    assert [((b - BEGAN_NS) / 1e9, (e - BEGAN_NS) / 1e9) for b, e in groups] == [(1.0, 9.9)]
    with Run(database) as run:
        assert identities.groups(run) == [Group(5, 1.0, 9.9, (1, 2))]
        assert identities.groups(run, (7.0, 8.0)) == [Group(5, 4.1, 9.9, (2,))]
        assert identities.groups(run, (10.0, 11.0)) == []


def test_which_video_shows_a_track(database):
    ticks = [tick(k, {1: (0, 0)}, cameras=[2 if 20 <= k < 50 else 1]) for k in range(100)]
    write(database, ticks, cameras=('north', 'south'))
    with Run(database) as run:
        first_ns = run.ns(-10.0)
        link_videos(run, [VideoFile('south', 'south.mp4', first_ns, first_ns + 60 * 10**9)])
        (shown,) = showings(run, 1)
        assert (shown.camera, shown.began_s, shown.ended_s) == ('south', 2.0, 4.9)
        assert (shown.video_from_s, shown.video_to_s) == (12.0, 14.9)
        with pytest.raises(StoreError, match='no camera west'):
            link_videos(run, [VideoFile('west', 'west.mp4', 0, 1)])


def test_the_open_span_is_seen(database):
    writer = TrajectoryWriter(database, NewRun('a'))
    for k in range(12):
        writer.write_tracks(tick(k, {1: (k, 0), 2: (k, 1)}))
    writer.flush()
    with Run(database) as run:
        assert [each.track_id for each in near(run, 1, 1.5)] == [2]
        assert [each.track_id for each in summaries(run)] == [1, 2]
    writer.close()


def test_answers_as_table_json_geojson_csv_and_parquet(place, database, tmp_path):
    ticks = [tick(k, {1: (k * 0.1, 0), 2: (k * 0.1, 1)}) for k in range(50)]
    write(database, ticks)
    question = ('near', '1', '--from', '1', '--within', '2')

    def ask(*options):
        code, output, errors = mctrack('query', place, *question, *options)
        assert code == 0, errors
        return output

    assert '1.000' in ask()
    (answer,) = json.loads(ask('--format', 'json'))
    assert (answer['track_id'], answer['began_s'], answer['ended_s']) == (2, 1.0, 4.9)
    (feature,) = json.loads(ask('--format', 'geojson'))['features']
    assert feature['geometry']['type'] == 'Point'
    (row,) = csv.DictReader(io.StringIO(ask('--format', 'csv')))
    assert float(row['closest_m']) == pytest.approx(1.0)
    ask('--out', str(tmp_path / 'near.parquet'))
    parquet = pytest.importorskip('pyarrow.parquet')
    assert parquet.read_table(tmp_path / 'near.parquet').to_pylist()[0] == answer


def test_what_nobody_has_is_no_empty_answer(place, database, tmp_path):
    ticks = [tick(k, {1: (0, 0), 2: (9, 9)} if k < 20 else {1: (0, 0)}) for k in range(50)]
    ticks += [tick(k, {1: (0, 0), 3: (9, 9)}) for k in range(60, 90)]
    write(database, ticks, [correction(61, (2, 3))], name='first')
    write(database, [tick(0, {1: (0, 0)})], name='second')

    def ask(*question):
        code, output, errors = mctrack('query', place, *question)
        return code, ' '.join((output + errors).split())

    code, listed = ask('runs', '--format', 'json')
    first, second = json.loads(listed)
    assert (code, first['run'], second['run']) == (0, 'first', 'second')
    assert (first['seconds'], first['began']) == (8.9, '2023-11-14T22:13:20+00:00')
    assert 'mctrack query DATABASE runs' in ask('tracks')[1]
    of_first = ('--run', 'first')
    for question in (('trajectory', '9'), ('near', '9'), ('events', '--track', '9')):
        assert ask(*question, *of_first) == (1, 'mctrack: run first has no track 9')
    assert 'track 2 is called 3 now' in ask('trajectory', '2', *of_first)[1]
    assert ask('trajectory', '2', '--as-reported', *of_first)[0] == 0
    assert ask('near', '1', '--within', '0.5', *of_first)[0] == 0
    for options in (('--from', '5', '--to', '5'), ('--as-of', 'nan'), ('--out', 'a.xlsx')):
        assert ask('tracks', *of_first, *options)[0] == 2


def test_every_question_of_the_command_line(place, tracked, tmp_path):
    code, _, errors = mctrack('store', tracked, place, '--run', 'match')
    assert code == 0, errors
    for question in (
        ['tracks'],
        ['trajectory', '2'],
        ['near', '50,30', '--within', '20'],
        ['meetings'],
        ['events', '--kind', 'exit', '--area', '0,0 200,0 200,200 0,200'],
        ['events'],
        ['crossings', '50,0 50,70'],
        ['crossings', '--line', 'halfway'],
        ['occupancy', '0,0 105,0 105,68 0,68'],
        ['occupancy', '--zone', 'right half'],
        ['heat-map', '--cell', '5'],
        ['videos', '2'],
    ):
        code, output, errors = mctrack('query', place, *question, '--format', 'json')
        assert code == 0, errors
        assert question[0] in {'videos', 'events'} or json.loads(output), question
    code, _, errors = mctrack('store', tracked, place, '--run', 'match')
    assert (code, errors.splitlines()[-1]) == (1, 'mctrack: run match is in the database already')
    assert mctrack('export-bag', place, tmp_path / 'bag')[0] == 0
    code, output, errors = mctrack('export', place, tmp_path / 'a.csv')
    assert code == 0, errors
    with Run(place) as run:
        ids = [each.track_id for each in summaries(run)]
        assert f' of {len(ids)} tracks' in output
        assert set(ids) <= set(track_ids(run))
        assert len(run.stamps()) == 150
        assert run.description()['cameras'] == [f'cam{number}' for number in range(1, 6)]
    assert mctrack('query', tracked, 'tracks')[1] == mctrack('query', place, 'tracks')[1]
    assert mctrack('query', place, 'near', 'nobody')[0] == 2
    code, _, errors = mctrack('query', place, 'crossings', '--line', 'door')
    assert code == 2
    assert "the site has no 'door', but halfway" in ' '.join(errors.split())
    assert mctrack('query', place, 'occupancy')[0] == 2


def test_times_are_seconds_or_dates(tmp_path):
    place = tmp_path / 'match.db'
    with Database(place, create=True) as database:
        write(database, [tick(k, {1: (k * 0.1, 0.0)}) for k in range(200)])
    began = datetime.fromtimestamp(BEGAN_NS // 10**9, UTC)

    def rows(*options):
        code, output, errors = mctrack('query', place, 'trajectory', 1, *options, '--format=json')
        assert code == 0, errors
        return json.loads(output)

    by_seconds = rows('--from', 5, '--to', 7.5)
    assert [each['time_s'] for each in by_seconds] == pytest.approx(np.arange(5, 7.5, 0.1))
    dates = [(began + timedelta(seconds=each)).isoformat() for each in (5, 7.5)]
    assert rows('--from', dates[0], '--to', dates[1]) == by_seconds
    plain = (began + timedelta(seconds=5)).strftime('%Y-%m-%dT%H:%M:%S')
    assert rows('--from', plain, '--to', 7.5) == by_seconds
    ahead = (began + timedelta(seconds=5)).astimezone(timezone(timedelta(hours=2))).isoformat()
    assert rows('--from', ahead, '--to', 7.5) == by_seconds
    assert len(rows('--as-of', dates[0])) == 51
    for wrong in ('noon', 'nan', '2026-13-01'):
        code, _, errors = mctrack('query', place, 'tracks', '--from', wrong)
        assert (code, 'is no time' in errors) == (2, True), errors
    code, _, errors = mctrack('query', place, 'tracks', '--from', dates[1], '--to', dates[0])
    assert (code, 'is not after' in errors) == (2, True), errors


def test_several_runs_are_asked_at_once(tmp_path):
    place = tmp_path / 'match.db'
    with Database(place, create=True) as database:
        for name, who in (('match', 1), ('match-2', 2), ('other', 3)):
            write(database, [tick(k, {who: (k * 0.1, 0.0)}) for k in range(50)], name=name)
    code, output, errors = mctrack('query', place, 'tracks', '--run', 'match*', '--format', 'json')
    assert code == 0, errors
    assert [(each['run'], each['track_id']) for each in json.loads(output)] == [
        ('match', 1),
        ('match-2', 2),
    ]
    code, output, _ = mctrack('query', place, 'tracks', '--run', 'm*-2', '--format', 'csv')
    assert output.startswith('track_id,')
    code, _, errors = mctrack('query', place, 'tracks', '--run', 'x*')
    assert (code, 'has no run x*' in errors) == (1, True), errors


def test_what_cannot_be_answered_is_refused(tmp_path):
    place = tmp_path / 'match.db'
    with Database(place, create=True) as database:
        write(database, [tick(k, {1: (k * 0.1, 0.0)}) for k in range(200)])
    code, _, errors = mctrack(
        'query', place, 'occupancy', '0,-1 5,-1 5,1 0,1', '--per', 0.001, '--to', 1e9
    )
    assert code == 0, errors  # no more periods than the run has
    with Run(place) as run, pytest.raises(ValueError, match='ask for longer ones'):
        occupancy(run, [(0, -1), (5, -1), (5, 1)], per_s=1e-6)
    missing = tmp_path / 'missing' / 'a.csv'
    for command in (('query', place, 'tracks', '--out', missing), ('export', place, missing)):
        code, _, errors = mctrack(*command)
        assert (code, 'there is no folder' in errors) == (2, True), errors
