"""What is deleted is gone with all its traces, and nothing else is."""

from concurrent.futures import ThreadPoolExecutor, wait

import numpy as np
import pytest

from command_line import mctrack
from mctrack_ros.interfaces import EventCode, Events, Tracks
from mctrack_ros.store import (
    Database,
    Keep,
    NewRun,
    Run,
    StoreError,
    TrajectoryWriter,
    VideoFile,
    check,
    events,
    forget_old,
    forget_track,
    link_videos,
    summaries,
    trajectory,
)
from mctrack_ros.store.rows import load_rows

BEGAN_NS = 1_700_000_000_000_000_000
TICK_NS = 100_000_000


def tick(k, places, **columns):
    position = [(x, y, 0.0) for x, y in places.values()]
    return Tracks.build(
        BEGAN_NS + k * TICK_NS, track_id=list(places), position=position, **columns
    )


def event(k, **columns):
    return Events.build(BEGAN_NS + k * TICK_NS, **columns)


def correction(k, *pairs):
    old, new = zip(*pairs)
    code = [EventCode.CORRECTION] * len(pairs)
    return event(k, event=code, track_id=new, old_id=old, new_id=new)


@pytest.fixture
def crowd(database):
    """
    Return a database of six people in twelve seconds, and the writer, which goes on.

    1 and 2 are exchanged at 5 s, which is noticed at 8 s; 3 is lost and comes again as 4, which is
    corrected to 3; 5 is two tracks of one person, 5 and 6; 7 has nothing to do with them. From
    10 s on all is in the journal.
    """
    happened = {
        20: event(20, event=[EventCode.NEW] * 3, track_id=[1, 2, 7], position=[(1, 1, 0)] * 3),
        60: event(60, event=[EventCode.EXIT] * 3, track_id=[1, 2, 7]),
        65: event(65, event=[EventCode.MERGE], track_id=[7], others=[[2] + [0] * 15]),
        70: correction(70, (4, 3)),
        75: correction(75, (6, 5)),
        80: correction(80, (1, 2), (2, 1)),
        110: event(110, event=[EventCode.EXIT, EventCode.EXIT], track_id=[3, 7]),
    }
    of_camera = event(
        60, event=[EventCode.EXIT] * 2, local_id=[4, 5], track_id=[1, 7], camera=[0, 0]
    )
    writer = TrajectoryWriter(database, NewRun('a', cameras=('north',)))
    for k in range(120):
        x = k * 0.1
        first, second = (x, 0.5 * (x > 5)), (10 - x, -0.5 * (x < 5))
        names = (1, 2) if k < 50 or k >= 80 else (2, 1)
        places = dict(zip(names, (first, second)))
        places |= {3 if k < 30 or k >= 70 else 4: (x, 20)}
        places |= {5: (x, 30)} | ({6: (x, 30.2)} if 40 <= k < 75 else {})
        places[7] = (x, 40)
        group = [9 if each in {1, 2, 7} and k > 10 else 0 for each in places]
        writer.write_tracks(tick(k, places, group=group))
        if k in happened:
            writer.write_events(happened[k])
        if k == 60:
            writer.write_events(of_camera, '/north/events')
    writer.flush()
    yield database, writer
    writer.close()


def answers(database, life):
    """Return where somebody was, and what happened to them."""
    with Run(database) as run:
        places = [(each.stamp_ns, each.x, each.y) for each in trajectory(run, life)]
        kinds = ('new', 'exit', 'merge')
        happened = [
            (each.event, each.stamp_ns) for each in events(run, track=life) if each.event in kinds
        ]
    return places, happened


@pytest.mark.parametrize(('life', 'ids'), [(1, {1}), (2, {2}), (3, {3, 4}), (5, {5, 6}), (7, {7})])
def test_a_track_is_forgotten_under_all_its_ids(crowd, life, ids):
    database, _ = crowd
    others = {each: answers(database, each) for each in {1, 2, 3, 5, 7} - {life}}
    rows = len(answers(database, life)[0])
    found = forget_track(database, life)
    assert (found.rows >= rows > 100, found.goes_on) == (True, True)
    assert check(database) == []
    assert answers(database, life) == ([], [])
    for other, (places, happened) in others.items():
        now = answers(database, other)
        assert now[0] == places
        shared = {('merge', BEGAN_NS + 65 * TICK_NS)} if life in {1, 7} else set()
        assert set(happened) - set(now[1]) <= shared
    with Run(database) as run:
        assert {each.track_id for each in summaries(run)} == {1, 2, 3, 5, 7} - {life}
        with database.connected() as connection:
            left = load_rows(connection, run.stored, (0, 2**63 - 1)).track_id
            named = {row.track_id for row in connection.exec_driver_sql('SELECT * FROM events')}
            members = {
                row.track_id for row in connection.exec_driver_sql('SELECT * FROM group_members')
            }
            corrected = connection.exec_driver_sql('SELECT old_id, new_id FROM corrections').all()
    corrected = {each for row in corrected for each in row}
    assert not ids & (set(left.tolist()) | named | members | corrected)
    assert members == {1, 2, 7} - {life}


def test_who_is_unknown_cannot_be_forgotten(crowd):
    database, _ = crowd
    for track in (4, 8, 0):
        with pytest.raises(StoreError, match=f'{track}'):
            forget_track(database, track)
    assert check(database) == []


def test_a_track_of_a_finished_run_does_not_go_on(crowd):
    database, writer = crowd
    writer.close()
    assert not forget_track(database, 7).goes_on
    assert check(database) == []


def content(path):
    files = [path, path.with_name(path.name + '-wal')]
    return b''.join(file.read_bytes() for file in files if file.exists())


def test_nothing_of_a_forgotten_track_stays_in_the_file(tmp_path):
    """Random places do not compress: their blobs would be found."""
    random = np.random.default_rng(3)
    path = tmp_path / 'tracks.db'
    with Database(path, create=True) as database:
        with TrajectoryWriter(
            database, NewRun('a'), clock=iter(np.arange(0, 1e6, 0.04)).__next__
        ) as writer:
            for k in range(300):
                position = random.uniform(0, 100, (4, 3))
                writer.write_tracks(
                    Tracks.build(
                        BEGAN_NS + k * 40_000_000, track_id=[1, 2, 3, 4], position=position
                    )
                )
        with database.connected() as connection:
            asked = 'SELECT places FROM chunks WHERE track_id = {}'
            blobs = {
                track: [bytes(row[0]) for row in connection.exec_driver_sql(asked.format(track))]
                for track in (2, 3)
            }
            pieces = {
                track: [
                    blob[at : at + 16] for blob in each for at in range(40, len(blob) - 16, 300)
                ]
                for track, each in blobs.items()
            }
        database.release()
        assert all(piece in content(path) for track in (2, 3) for piece in pieces[track])
        forget_track(database, 2)
        database.release()
        found = content(path)
        assert not any(piece in found for piece in pieces[2])
        assert all(piece in found for piece in pieces[3])
        assert check(database) == []


def test_old_data_go_by_kind(database):
    for name, from_k in (('old', 0), ('new', 600)):
        with TrajectoryWriter(database, NewRun(name, cameras=('north',))) as writer:
            for k in range(from_k, from_k + 200):
                places = {1: (k, 0)} | ({2: (k, 1)} if k < 20 else {}) | {3: (k, 2)}
                writer.write_tracks(tick(k, places, group=[4 if k < 25 else 0] * len(places)))
                if k % 50 == 0:
                    writer.write_events(event(k, event=[EventCode.EXIT], track_id=[1]))
                    writer.write_events(correction(k + 1, (9, 3)))
    with Run(database, 'old') as run:
        videos = [VideoFile('north', f'{k}.mp4', run.ns(k), run.ns(k + 5)) for k in (0, 10)]
        link_videos(run, videos)
    now_ns = BEGAN_NS + 100 * 10**9

    def left(table):
        with database.connected() as connection:
            return connection.exec_driver_sql(f'SELECT count(*) FROM {table}').scalar()

    assert forget_old(database, Keep(), now_ns) == {}
    assert forget_old(database, Keep.parsed('videos=93s'), now_ns) == {'videos': 1}
    assert forget_old(database, Keep(corrections=91.0), now_ns) == {'corrections': 2}
    assert (left('corrections'), left('events'), left('event_messages')) == (6, 14, 14)
    assert forget_old(database, Keep(events=91.0), now_ns) == {'events': 2}
    assert check(database) == []
    found = forget_old(database, Keep(positions=95.0), now_ns)
    assert found == {'positions': 2 * 40 + 20}
    assert check(database) == []
    assert left('group_members') == 0
    with Run(database, 'old') as run:
        assert trajectory(run, 1)[0].stamp_ns == BEGAN_NS + 40 * TICK_NS
        assert [each.track_id for each in summaries(run)] == [1, 3]
        assert summaries(run)[0].began_s == 4.0
    forget_old(database, Keep.parsed('70s'), now_ns)
    assert check(database) == []
    with database.connected() as connection:
        assert connection.exec_driver_sql('SELECT name FROM runs').scalars().all() == ['new']
    with Run(database) as run:
        assert len(trajectory(run, 1)) == 200


def test_an_abandoned_journal_grows_old_too(database):
    writer = TrajectoryWriter(database, NewRun('a'))
    for k in range(30):
        writer.write_tracks(tick(k, {1: (k, 0)}))
    writer.flush()
    assert forget_old(database, Keep(positions=10.0), BEGAN_NS + 10**11) == {'positions': 30}
    with database.connected() as connection:
        assert connection.exec_driver_sql('SELECT count(*) FROM runs').scalar() == 0
    assert check(database) == []


@pytest.mark.parametrize('text', ['30', 'people=30d', '30d,', 'positions', '-1d', 'positions=1w'])
def test_an_age_that_is_none_is_refused(text):
    with pytest.raises(StoreError, match='is no age to keep, expected 30d, or positions=30d'):
        Keep.parsed(text)


def test_ages_are_read():
    assert Keep.parsed('1.5h') == Keep(5400.0, 5400.0, 5400.0, 5400.0)
    assert Keep.parsed('positions=30d, events=10s') == Keep(30 * 86400.0, 10.0)
    assert Keep.parsed('') == Keep()


def test_the_commands_check_and_forget(place, tracked):
    def ask(*words):
        code, output, errors = mctrack(*words)
        return code, [*output.splitlines(), *errors.splitlines()]

    assert mctrack('store', tracked, place, '--run', 'match')[0] == 0
    assert mctrack('forget', place)[0] == 2
    code, lines = ask('forget', place, '--track', '7')
    assert (code, lines[0].split(' rows')[0]) == (0, 'deleted track 7: 125')
    assert ask('forget', place, '--track', '7') == (1, ['mctrack: run match has no track 7'])
    assert ask('store-check', place)[0] == 0
    with Database(place) as database, database.connected() as connection:
        connection.exec_driver_sql('DELETE FROM rests')
    code, lines = ask('store-check', place)
    assert code == 1
    assert 'has no second blob' in lines[0]
    assert ask('forget', place, '--keep', 'positions=1d')[0] == 0
    assert ask('forget', place, '--whole-run', '--run', 'match') == (0, ['deleted run match'])
    assert ask('store-check', place)[0] == 0


def test_who_forgets_while_another_writes_is_told_that_this_takes_a_while(place, tracked):
    assert mctrack('store', tracked, place, '--run', 'match')[0] == 0
    with Database(place) as database, ThreadPoolExecutor() as pool:
        with database.alone():
            asked = pool.submit(mctrack, 'forget', place, '--whole-run')
            assert wait([asked], timeout=3.5).not_done
        code, output, errors = asked.result()
    assert (code, output) == (0, 'deleted run match\n')
    assert 'who else writes now is waited for' in errors
