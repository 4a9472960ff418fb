import dataclasses
import json

import numpy as np
import pytest

from drawn_hall import walkers, write_hall
from mctrack_ros.codec import rows_from_cloud
from mctrack_ros.interfaces import REPORTED, EventCode, Events, Ticks, Tracks
from mctrack_ros.recording import BagError, BagReader, BagWriter
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.lockstep import ReplayError
from mctrack_ros.replay.recorded import recorded_ticks
from mctrack_ros.replay.track import track_bag
from mctrack_ros.zones.shapes import Line, Zone, Zones

pytestmark = pytest.mark.xdist_group('replay')


@pytest.fixture(scope='module')
def hall(tmp_path_factory):
    """Return a bag of two cameras in step, and its site, which has a zone and a line."""
    bag, site = write_hall(tmp_path_factory.mktemp('hall'))
    half = Zone('left half', ((-9.0, -9.0), (0.0, -9.0), (0.0, 9.0), (-9.0, 9.0)))
    middle = Line('middle', ((0.0, -9.0), (0.0, 9.0)))
    return bag, dataclasses.replace(site, zones=Zones((half,), (middle,)))


@pytest.fixture(scope='module')
def tracked(hall, tmp_path_factory):
    """Return the folder of results made by two processes."""
    out = tmp_path_factory.mktemp('out')
    summary = track_bag(*hall_arguments(hall, out), processes=2)
    assert summary.ticks == 188
    assert summary.images == 376
    assert summary.peak_memory_mb > 50.0
    written = {int(line.split(',')[1]) for line in (out / 'tracks.txt').read_text().splitlines()}
    assert summary.confirmed_ids == written
    return out


def hall_arguments(hall, out):
    bag, site = hall
    return bag, out, site


def results(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob('*') if p.is_file()}


def rows_of(bag, topic, kind):
    with BagReader(bag) as reader:
        return [rows_from_cloud(message, kind) for _, message, _ in reader.messages([topic])]


def test_the_site_in_the_bag_says_the_run_and_another_recording_is_another_run(hall, tracked):
    _, site = hall
    with BagReader(tracked / 'bag') as reader:
        (message,) = (message for _, message, _ in reader.messages(['/site']))
        began_ns = next(stamp for _, _, stamp in reader.messages(['/ticks']))
    assert message.data == site.description(began_ns)
    run = json.loads(message.data)['run']
    assert run == json.loads(site.description(began_ns))['run']
    assert run != json.loads(site.description(began_ns + 1))['run']


def test_people_are_found_where_they_walk_with_one_id_each(tracked):
    instants = rows_of(tracked / 'bag', '/tracks', Tracks)[90:]
    ids = [set() for _ in range(3)]
    for tracks in instants:
        shown = tracks.select(np.isin(tracks.status, REPORTED))
        truth = walkers(tracks.stamp_ns * 1e-9 - 1000)
        distance = np.linalg.norm(shown.position[None, :, :2] - truth[:, None], axis=2)
        assert (distance.min(axis=1) < 0.6).all()
        for person, nearest in enumerate(distance.argmin(axis=1)):
            ids[person].add(int(shown.track_id[nearest]))
    assert [len(each) for each in ids] == [1, 1, 1]


def test_zone_events_are_among_the_events_and_the_site_names_their_zones(tracked):
    """One walks to the left half, one out of it, one stays in the other."""
    told = rows_of(tracked / 'bag', '/events', Events)
    events = Events.joined(0, told)
    happened = {
        name: events.zone[events.event == EventCode[name]].tolist()
        for name in ('CROSS_LEFT', 'CROSS_RIGHT', 'ENTER_ZONE', 'LEAVE_ZONE')
    }
    assert happened == {
        'CROSS_LEFT': [2],
        'CROSS_RIGHT': [2],
        'ENTER_ZONE': [1, 1],
        'LEAVE_ZONE': [1],
    }
    assert all((np.diff(each.event.astype(int)) >= 0).all() for each in told)
    with BagReader(tracked / 'bag') as reader:
        (message,) = (message for _, message, _ in reader.messages(['/site']))
    zones = json.loads(message.data)['zones']
    assert [(each['index'], each['kind'], each['name']) for each in zones] == [
        (1, 'zone', 'left half'),
        (2, 'line', 'middle'),
    ]


@pytest.mark.parametrize('processes', [1, 2])
def test_two_runs_give_the_same_bytes_whatever_the_processes(hall, tracked, tmp_path, processes):
    track_bag(*hall_arguments(hall, tmp_path), processes=processes)
    assert results(tmp_path) == results(tracked)


def test_replaying_the_recorded_detections_gives_the_same_tracks(hall, tracked, tmp_path):
    _, site = hall
    track_bag(tracked / 'bag', tmp_path, site, processes=1)
    assert (tmp_path / 'tracks.txt').read_bytes() == (tracked / 'tracks.txt').read_bytes()


def test_the_record_of_ticks_repeats_the_fusion(hall, tracked):
    _, site = hall
    tracks = rows_of(tracked / 'bag', '/tracks', Tracks)
    with BagReader(tracked / 'bag') as reader:
        ticks = list(recorded_ticks(reader, site.camera_names, site.fusion))
    assert all(tick.record.admitted.tolist() == [1, 1] for tick in ticks)
    repeated = drive(site.fusion, site.camera_names, ticks)
    for again, recorded in zip(repeated, tracks, strict=True):
        again = again.output.tracks
        assert again.position.tobytes() == recorded.position.tobytes()
        assert again.track_id.tolist() == recorded.track_id.tolist()


def test_cameras_need_not_be_triggered_together(tmp_path):
    bag, site = write_hall(tmp_path, seconds=3.0, offset_ns=29_000_000)
    track_bag(bag, tmp_path / 'out', site)
    records = rows_of(tmp_path / 'out' / 'bag', '/ticks', Ticks)
    assert len(records) == 75
    assert all(record.admitted.tolist() == [1, 1] for record in records)
    assert sum(int(record.late.sum()) for record in records) == 0


def test_a_camera_that_ends_early_does_not_stop_the_rest(hall, tmp_path):
    bag, site = hall
    with BagReader(bag) as reader, BagWriter(tmp_path / 'bag') as writer:
        start = None
        for topic, kind, data, time_ns in reader.serialized():
            start = start or time_ns
            if topic.startswith('/north') or time_ns < start + 1_000_000_000:
                writer.write_serialized(topic, kind, data, time_ns)
    track_bag(tmp_path / 'bag', tmp_path / 'out', site)
    records = rows_of(tmp_path / 'out' / 'bag', '/ticks', Ticks)
    assert len(records) == 188
    assert records[-1].alive.tolist() == [1, 0]


def test_a_camera_without_images_is_named(hall, tmp_path):
    bag, site = hall
    with BagReader(bag) as reader, BagWriter(tmp_path / 'bag') as writer:
        for topic, kind, data, time_ns in reader.serialized(['/north/image_raw/compressed']):
            writer.write_serialized(topic, kind, data, time_ns)
    with pytest.raises(BagError, match='no messages on /south/image_raw/compressed'):
        track_bag(tmp_path / 'bag', tmp_path / 'out', site)


def test_images_of_another_size_stop_the_run_with_the_reason(hall, tmp_path):
    bag, site = hall
    camera = dataclasses.replace(site.cameras['north'], image_width=640)
    wrong = dataclasses.replace(site, cameras={**site.cameras, 'north': camera})
    with pytest.raises(BagError, match='image is 320 x 240, expected 640 x 240'):
        track_bag(bag, tmp_path / 'out', wrong)


def test_feedback_of_the_running_tick_is_refused(hall, tmp_path):
    bag, site = hall
    impatient = dataclasses.replace(site, feedback_delay=0.01)
    with pytest.raises(ReplayError, match='expected at least the period'):
        track_bag(bag, tmp_path / 'out', impatient)


def test_a_period_that_does_not_suit_the_cameras_is_named(hall, tmp_path):
    bag, site = hall
    batching = dataclasses.replace(site.fusion.batching, period=0.05)
    fusion = dataclasses.replace(site.fusion, batching=batching)
    slow = dataclasses.replace(site, fusion=fusion, feedback_delay=0.1)
    notes = track_bag(bag, tmp_path / 'out', slow).notes
    assert any('every 0.0400 s' in note and 'batching.period to 0.0400' in note for note in notes)


def test_earlier_results_are_kept_unless_asked(hall, tracked):
    bag, site = hall
    with pytest.raises(BagError, match='exists already'):
        track_bag(bag, tracked, site)
