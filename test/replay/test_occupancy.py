"""People are tracked by the masks of a bag's cameras, from images and from what was recorded."""

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest
import yaml

from drawn_hall import walkers, write_hall
from mctrack_ros.config import ConfigError
from mctrack_ros.explain.history import history_of
from mctrack_ros.fusion import JointConfig
from mctrack_ros.interfaces import Detections, Foreground, Ticks, Tracks, TrackStatus
from mctrack_ros.recording import BagError, BagReader, BagWriter
from mctrack_ros.replay.camera_source import CameraSource
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.lockstep import camera_tasks
from mctrack_ros.replay.proof.verify import Replay, verify_bag
from mctrack_ros.replay.recorded import recorded_settings, recorded_ticks
from mctrack_ros.replay.track import track_bag
from mctrack_ros.site.site import load_site

pytestmark = pytest.mark.xdist_group('replay')
AREA = '-6,-5,6,5'
CLOSE = {'east': (13.0, 1.0, 7.0), 'north': (-1.0, -13.0, 7.0), 'south': (1.0, 13.0, 7.0)}


@pytest.fixture(scope='module')
def tracked(tmp_path_factory):
    """Return a tracked bag, its site and where it lies."""
    folder = tmp_path_factory.mktemp('occupancy')
    bag, _ = write_hall(folder, seconds=4.0, positions=CLOSE)
    path = folder / 'site.yaml'
    content = yaml.safe_load(path.read_text()) | {'area': AREA}
    content['pipeline'] = {'background': {'learning_s': 1.0}}
    # people are drawn 0.6 m wide, and JPEG colours two more pixels on either side
    content['fusion'] = {'tracker': 'occupancy', 'people': {'person_width': 0.75}}
    path.write_text(yaml.safe_dump(content))
    site = load_site(path)
    summary = track_bag(bag, folder / 'out', site)
    assert summary.ticks == 100
    return folder / 'out/bag', site, folder


def rows(bag, topic, kind):
    with BagReader(bag) as reader:
        return [each for each, _ in reader.rows(topic, kind)]


def data(bag, topic):
    with BagReader(bag) as reader:
        return [message for _, _, message, _ in reader.serialized([topic])]


def without(bag, out, dropped, topic):
    """Copy a bag without some messages of a topic, and without its ticks and what came out."""
    with BagReader(bag) as reader, BagWriter(out) as writer:
        kept = [t for t in reader.topics if t.endswith(('/detections', '/compressed'))]
        index = 0
        for name, kind, message, time_ns in reader.serialized(kept):
            index += name == topic
            if name != topic or index not in dropped:
                writer.write_copy(reader, name, kind, message, time_ns)
    return out


def test_people_are_found_where_they_walk(tracked):
    tracks = rows(tracked[0], '/tracks', Tracks)
    for each in tracks[-25:]:
        each = each.select(each.status == TrackStatus.CONFIRMED)
        people = walkers(each.stamp_ns * 1e-9 - 1000)
        gaps = np.linalg.norm(each.position[:, None, :2] - people, axis=2)
        assert gaps.shape == (3, 3)
        assert gaps.min(axis=0).max() < 0.5
        assert (each.cameras > 0).all()


def test_masks_are_recorded_as_small_images(tracked):
    bag, site, _ = tracked
    for camera in site.camera_names:
        with BagReader(bag) as reader:
            assert reader.topics[f'/{camera}/foreground/compressed'].endswith('CompressedImage')
            messages = [m for _, m, _ in reader.messages([f'/{camera}/foreground/compressed'])]
        assert len(messages) == 100
        assert np.mean([len(message.data) for message in messages]) < 500
        image = cv2.imdecode(messages[-1].data, cv2.IMREAD_UNCHANGED)
        assert set(np.unique(image).tolist()) == {0, 255}
        told = rows(bag, f'/{camera}/foreground/compressed', Foreground)
        assert all(len(each.mask) > 0 for each in told)


def test_fusing_the_recorded_messages_again_gives_the_same_bytes(tracked):
    bag, site, folder = tracked
    track_bag(bag, folder / 'again', site)
    for topic in ('/tracks', '/feedback', '/ticks'):
        assert data(bag, topic) == data(folder / 'again/bag', topic)
    with BagReader(bag) as reader:
        ticks = recorded_ticks(reader, site.camera_names, site.fusion)
        told = [
            each.output.tracks
            for each in drive(site.fusion, site.camera_names, ticks, views=site.views)
        ]
    for one, other in zip(told, rows(bag, '/tracks', Tracks), strict=True):
        for name in one.COLUMNS:
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize('topics', ['detections', 'detections and masks'])
def test_a_tracker_is_chosen_for_recorded_masks_as_for_images(tracked, topics):
    bag, site, folder = tracked
    unnamed = replace(site, fusion=JointConfig(), names_tracker=False)
    kept = ('/detections', '/compressed') if 'masks' in topics else ('/detections',)
    out = folder / topics
    with BagReader(bag) as reader, BagWriter(out) as writer:
        names = [topic for topic in reader.topics if topic.endswith(kept)]
        for name, kind, message, time_ns in reader.serialized(names):
            writer.write_copy(reader, name, kind, message, time_ns)
    summary = track_bag(out, folder / f'{topics} out', unnamed)
    assert ('own detections do not have' in summary.tracker) == ('masks' not in topics)
    with BagReader(out) as reader:
        _, fusion = recorded_settings(reader, unnamed)
    assert (fusion.tracker == 'occupancy') == ('tracker occupancy' in summary.tracker)


def test_an_image_whose_mask_was_lost_is_left_out_and_the_others_go_on(tracked):
    bag, site, folder = tracked
    topic = '/north/foreground/compressed'
    cut = without(bag, folder / 'cut', {80, 81}, topic)
    summary = track_bag(cut, folder / 'cut_out', site)
    assert summary.ticks == 100
    ticks = rows(folder / 'cut_out/bag', '/ticks', Ticks)
    assert [int(t.admitted[1]) for t in ticks[78:83]] == [1, 0, 0, 1, 1]
    last = rows(folder / 'cut_out/bag', '/tracks', Tracks)[-1]
    assert (last.status == TrackStatus.CONFIRMED).sum() == 3


def test_a_run_names_the_cameras_whose_masks_were_left_out(tracked):
    bag, site, folder = tracked
    assert not track_bag(bag, folder / 'whole', site).masks_left_out()
    cut = without(bag, folder / 'silent', set(range(40, 60)), '/north/foreground/compressed')
    summary = track_bag(cut, folder / 'silent_out', site)
    (said,) = summary.masks_left_out()
    assert said in summary.notes
    assert re.fullmatch(
        r'north: its mask is left out of 1\d of 100 ticks: it sent no mask for 0\.3 s', said
    )


def test_messages_of_an_image_are_found_whichever_was_logged_first(tracked):
    bag, site, folder = tracked
    with BagReader(bag) as reader, BagWriter(folder / 'late') as writer:
        logged = [
            (time_ns + 100_000_000 * topic.endswith('compressed'), topic, kind, message)
            for topic, kind, message, time_ns in reader.serialized(
                [t for t in reader.topics if t.endswith(('/detections', '/compressed'))]
            )
        ]
        for time_ns, topic, kind, message in sorted(logged, key=lambda one: one[0]):
            writer.write_copy(reader, topic, kind, message, time_ns)
    task = camera_tasks(folder / 'late', site)[0]
    source, stamps = CameraSource(task), []
    while source.next_stamp_ns is not None:
        result = source.step()
        stamps.append(result.stamp_ns)
        assert {each.stamp_ns for each in result.messages.values()} == {result.stamp_ns}
    assert stamps == [each.stamp_ns for each in rows(bag, '/north/detections', Detections)]


def test_a_bag_of_detections_alone_is_refused(tracked):
    bag, site, folder = tracked
    with BagReader(bag) as reader, BagWriter(folder / 'alone') as writer:
        topics = [f'/{name}/detections' for name in site.camera_names]
        for topic, kind, message, time_ns in reader.serialized(topics):
            writer.write_copy(reader, topic, kind, message, time_ns)
    with BagReader(folder / 'alone') as reader, pytest.raises(BagError, match='foreground'):
        next(recorded_ticks(reader, site.camera_names, site.fusion))
    with pytest.raises(BagError, match='foreground'):
        track_bag(folder / 'alone', folder / 'alone_out', site)


def test_it_is_explained_with_the_site_and_refused_without(tracked):
    bag, site, _ = tracked
    track_id = int(rows(bag, '/tracks', Tracks)[-1].track_id[0])
    history = history_of(bag, track_id, 3.9, site=site)
    assert history.is_same
    assert history.cameras == ('all',)
    with pytest.raises(ConfigError, match='name the site'):
        history_of(bag, track_id, 3.9)


def test_cameras_that_tell_no_masks_are_refused(tracked):
    path = tracked[2] / 'site.yaml'
    content = yaml.safe_load(path.read_text())
    content['cameras']['south']['pipeline'] = {'local_tracker': 'silhouettes'}
    other = path.with_name('silhouettes.yaml')
    other.write_text(yaml.safe_dump(content))
    with pytest.raises(ConfigError, match='takes detections and foreground/compressed'):
        load_site(other)


def test_a_replay_that_goes_on_from_a_state_gives_the_same_tracks(tracked):
    bag, _, _ = tracked
    first, state = verify_bag(bag, Replay(until_s=2.0))
    second, _ = verify_bag(bag, Replay(state=state))
    assert first.is_same
    assert second.is_same
    assert second.stored == second.digest
    assert first.ticks + second.ticks == 100
