"""People are tracked by belief propagation in a bag's cameras, and again from the recording."""

import numpy as np
import pytest
import yaml

from drawn_hall import PERIOD_NS, walkers, write_hall
from mctrack_ros.interfaces import Belief, Detections, Tracks, TrackStatus
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.proof.verify import Replay, verify_bag
from mctrack_ros.replay.track import track_bag
from mctrack_ros.site.site import load_site

pytestmark = pytest.mark.xdist_group('replay')
CLOSE = {'east': (13.0, 1.0, 7.0), 'north': (-1.0, -13.0, 7.0), 'south': (1.0, 13.0, 7.0)}
TOPICS = ('/tracks', '/belief', '/ticks', '/north/belief', '/north/detections')


@pytest.fixture(scope='module')
def tracked(tmp_path_factory):
    """Return a tracked bag, its site and where it lies."""
    folder = tmp_path_factory.mktemp('belief')
    bag, _ = write_hall(folder, seconds=6.0, positions=CLOSE)
    path = folder / 'site.yaml'
    content = yaml.safe_load(path.read_text())
    content['pipeline'] = {'local_tracker': 'belief', 'background': {'learning_s': 1.0}}
    content['fusion'] = {'tracker': 'belief'}
    path.write_text(yaml.safe_dump(content))
    site = load_site(path)
    assert track_bag(bag, folder / 'out', site).ticks == 150
    return folder / 'out/bag', site, folder


def rows(bag, topic, kind):
    with BagReader(bag) as reader:
        return [each for each, _ in reader.rows(topic, kind)]


def data(bag, topic):
    with BagReader(bag) as reader:
        return [message for _, _, message, _ in reader.serialized([topic])]


def test_people_are_found_and_keep_their_ids(tracked):
    last = rows(tracked[0], '/tracks', Tracks)[-50:]
    for each in last:
        each = each.select(each.status == TrackStatus.CONFIRMED)
        people = walkers(each.stamp_ns * 1e-9 - 1000)
        gaps = np.linalg.norm(each.position[:, None, :2] - people, axis=2)
        assert gaps.shape == (3, 3)
        assert gaps.min(axis=0).max() < 0.7
    assert last[0].track_id.tolist() == last[-1].track_id.tolist()


def test_cameras_send_their_particles_and_fusion_sends_them_back(tracked):
    bag, site, _ = tracked
    for camera in site.camera_names:
        told = rows(bag, f'/{camera}/belief', Belief)
        assert len(told) == 150
        assert not len(told[0])
        assert len(np.unique(told[-1].track_id)) == 3
        assert len(np.unique(told[-1].view)) == 1
    back = rows(bag, '/belief', Belief)[-1]
    assert len(np.unique(back.view)) == 4
    assert len(back) == 3 * 4 * 200


def test_the_same_bag_gives_the_same_bytes_however_many_processes(tracked):
    bag, site, folder = tracked
    track_bag(folder / 'bag', folder / 'alone', site, processes=1)
    for topic in TOPICS:
        assert data(bag, topic) == data(folder / 'alone/bag', topic), topic


def test_fusing_the_recorded_messages_again_gives_the_same_bytes(tracked):
    bag, site, folder = tracked
    track_bag(bag, folder / 'again', site)
    for topic in TOPICS[:3]:
        assert data(bag, topic) == data(folder / 'again/bag', topic)


def test_targets_start_where_the_bag_says_and_may_be_many(tmp_path):
    """Of so many particles neither a camera's process nor fusion's can send all at once."""
    place = [[x, y, 0.0] for x in range(-3, 4) for y in range(-3, 4)]
    asked = Detections.build(10**12 + 4 * PERIOD_NS, position=place)
    bag, _ = write_hall(tmp_path, seconds=0.4, positions=CLOSE, start=asked)
    path = tmp_path / 'site.yaml'
    content = yaml.safe_load(path.read_text())
    content['pipeline'] = {'local_tracker': 'belief', 'moving': True}
    content['fusion'] = {'tracker': 'belief'}
    path.write_text(yaml.safe_dump(content))
    track_bag(bag, tmp_path / 'out', load_site(path))
    tracks = rows(tmp_path / 'out/bag', '/tracks', Tracks)
    assert [each.track_id.tolist() for each in tracks] == [[]] * 4 + [list(range(1, 50))] * 6
    np.testing.assert_allclose(tracks[4].position, place, atol=0.1)


def test_a_replay_that_goes_on_from_a_state_gives_the_same_tracks(tracked):
    bag, _, _ = tracked
    first, state = verify_bag(bag, Replay(until_s=3.0))
    second, _ = verify_bag(bag, Replay(state=state))
    assert first.is_same
    assert second.is_same
    assert second.stored == second.digest
    assert first.ticks + second.ticks == 150
