"""A tracker that is registered runs through the replay, which knows nothing of it."""

import numpy as np
import pytest
import yaml

import foot_points
from drawn_hall import walkers, write_hall
from mctrack_ros.config import ConfigError
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagError, BagReader
from mctrack_ros.replay.doctor import examine_bag, examine_site
from mctrack_ros.replay.recorded import recorded_ticks
from mctrack_ros.replay.track import track_bag
from mctrack_ros.site.site import load_site

pytestmark = pytest.mark.xdist_group('replay')


@pytest.fixture
def hall(tmp_path, monkeypatch):
    """Return a bag and its site, whose trackers are the registered ones."""
    foot_points.register(monkeypatch)
    bag, _ = write_hall(tmp_path, seconds=3.0)
    path = tmp_path / 'site.yaml'
    content = yaml.safe_load(path.read_text())
    content['pipeline'] = {'local_tracker': 'feet', 'contrast': 40}
    content['fusion'] = {'tracker': 'feet', 'gate': 1.5}
    path.write_text(yaml.safe_dump(content))
    return bag, load_site(path)


def rows(bag, topic, kind):
    with BagReader(bag) as reader:
        return [each for each, _ in reader.rows(topic, kind)]


def test_it_tracks_a_bag_and_its_own_messages_and_feedback_are_recorded(hall, tmp_path):
    bag, site = hall
    summary = track_bag(bag, tmp_path / 'out', site)
    assert summary.ticks == 75
    found = rows(tmp_path / 'out/bag', '/tracks', Tracks)[-1]
    gaps = np.linalg.norm(
        walkers(found.stamp_ns * 1e-9 - 1000)[:, None] - found.position[None, :, :2], axis=2
    )
    assert gaps.min(axis=1).max() < 1.0
    told = rows(tmp_path / 'out/bag', '/north/foot_points', foot_points.FootPoints)
    assert max(map(len, told)) == 3
    fed_back = rows(tmp_path / 'out/bag', '/headcount', foot_points.Headcount)
    assert len(fed_back[-1]) == len(found)


def test_what_it_was_told_is_replayed_instead_of_images(hall, tmp_path):
    bag, site = hall
    track_bag(bag, tmp_path / 'out', site)
    summary = track_bag(tmp_path / 'out/bag', tmp_path / 'again', site)
    assert summary.ticks == 75
    once, again = (rows(tmp_path / name / 'bag', '/tracks', Tracks) for name in ('out', 'again'))
    for one, other in zip(once, again, strict=True):
        np.testing.assert_array_equal(one.position, other.position)
    with BagReader(tmp_path / 'out/bag') as reader:
        ticks = list(recorded_ticks(reader, site.camera_names, site.fusion))
    assert isinstance(ticks[-1].messages[0].rows, foot_points.FootPoints)


def test_a_bag_without_what_it_is_told_is_refused_by_the_topic(hall):
    bag, site = hall
    with BagReader(bag) as reader, pytest.raises(BagError, match='no foot_points of north, south'):
        next(recorded_ticks(reader, site.camera_names, site.fusion))


def test_the_doctor_examines_its_site(hall):
    bag, site = hall
    assert not [one for one in examine_site(site) if one.severity == 'error']
    assert not [one for one in examine_bag(bag, site) if one.severity == 'error']


def test_cameras_that_do_not_tell_what_fusion_wants_are_refused(hall, tmp_path):
    path = tmp_path / 'site.yaml'
    content = yaml.safe_load(path.read_text())
    content['cameras']['south']['pipeline'] = {'local_tracker': 'event_tracker'}
    content['pipeline'] = {'local_tracker': 'feet'}
    path.write_text(yaml.safe_dump(content))
    reason = (
        'cameras.south.pipeline.local_tracker is event_tracker, which publishes detections and '
        'foreground/compressed; '
    )
    with pytest.raises(ConfigError, match=reason + 'fusion.tracker feet takes foot_points'):
        load_site(path)
