"""The same bag gives the same tracks; what differs is found, to the field."""

import json
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.cli.sites import named_site
from mctrack_ros.interfaces import Detections
from mctrack_ros.recording import BagReader, BagWriter, attachments
from mctrack_ros.recording.track_log import log
from mctrack_ros.replay.proof.state import StateError
from mctrack_ros.replay.proof.verify import Replay, verify_bag
from mctrack_ros.replay.track import track_bag
from rewritten_bag import CLOUD, flipped, part_of, rewritten

pytestmark = pytest.mark.xdist_group('replay')
GOLDEN = Path(__file__).resolve().parents[2] / 'bags/pitch5_detections'
SECONDS, TICKS = (1.0, 2.2), 30


@pytest.fixture(scope='module')
def detections(tmp_path_factory):
    """Return a bag of the detections of five cameras."""
    return part_of(GOLDEN, tmp_path_factory.mktemp('golden') / 'bag', *SECONDS)


@pytest.fixture(scope='module')
def run(detections, tmp_path_factory):
    """Return the folder of a tracked run."""
    out = tmp_path_factory.mktemp('run') / 'out'
    track_bag(detections, out, named_site('pitch5'), processes=1)
    return out


def test_a_tracked_run_is_the_same_again_with_what_the_bag_carries(run):
    verdict, _ = verify_bag(run)
    assert verdict.is_same
    assert verdict.ticks == verdict.compared == TICKS
    assert verdict.stored == verdict.digest
    assert verdict.line().startswith(f'same: {TICKS} ticks, 1.160 s, track log ')
    said = json.loads(attachments(run / 'bag')[log.SUMMARY])
    assert said['logs']['/tracks'] == {'messages': TICKS, 'sha256': verdict.digest.hex()}


def test_what_cannot_be_compared_is_no_proof(detections):
    verdict, _ = verify_bag(detections, Replay(named_site('pitch5')))
    assert verdict.ticks == TICKS
    assert verdict.is_fault
    assert verdict.line().startswith(f'not compared, the bag holds no tracks: {TICKS} ticks')


def test_a_changed_bit_of_the_tracks_is_found(run, tmp_path):
    def change(topic, number, data):
        return flipped(data, 'velocity', 2, 9) if (topic, number) == ('/tracks', 20) else data

    verdict, _ = verify_bag(rewritten(run / 'bag', tmp_path / 'bag.mcap', change))
    assert verdict.is_fault
    assert verdict.stored == verdict.digest
    first = verdict.first
    assert (first.tick, first.field, first.row) == (20, 'velocity', 2)
    assert first.track_id > 0
    assert [(each.topic, each.field) for each in verdict.changed] == [('/tracks', 'velocity')]
    assert verdict.line().startswith(
        f'differs: tick 20 at 0.800 s, velocity of track {first.track_id}: recorded ['
    )


def test_a_changed_bit_of_a_detection_is_found_with_what_comes_of_it(run, tmp_path):
    def change(topic, number, data):
        wanted = ('/cam2/detections', 20)
        return flipped(data, 'x', 3, 20) if (topic, number) == wanted else data

    verdict, _ = verify_bag(rewritten(run / 'bag', tmp_path / 'bag.mcap', change))
    assert verdict.is_fault
    assert verdict.first.tick == 20
    assert verdict.digest != verdict.stored
    (changed,) = verdict.changed
    assert (changed.topic, changed.field) == ('/cam2/detections', 'x')
    assert 'x of /cam2/detections at 0.8' in verdict.line()


def test_a_changed_bit_that_stops_the_replay_is_found(run, tmp_path):
    def change(topic, number, data):
        return flipped(data, 'camera', 2, 9) if (topic, number) == ('/ticks', 12) else data

    verdict, _ = verify_bag(rewritten(run / 'bag', tmp_path / 'bag.mcap', change))
    assert verdict.is_fault
    assert [(each.topic, each.field) for each in verdict.changed] == [('/ticks', 'camera')]
    assert 'camera of /ticks at 0.480 s is not what was written; it ends there' in verdict.line()


@pytest.fixture(scope='module')
def stored(run):
    """Return the messages of the run, and what its bag says of them."""
    with BagReader(run / 'bag') as reader:
        messages = [each for each in reader.serialized() if each[1] == CLOUD and len(each[2])]
    return messages, log.StoredLog.of(attachments(run / 'bag'))


@settings(max_examples=200, deadline=None)
@given(data=st.data())
def test_any_changed_bit_of_any_field_is_found(stored, data):
    messages, said = stored
    topic, kind, content, time_ns = data.draw(st.sampled_from(messages))
    message = log.Canonical.of(kind, content, time_ns)
    assert not said.changed_field(topic, time_ns, message)
    name = data.draw(st.sampled_from([n for n, each in message.fields.items() if each] or ['']))
    if not name:
        return
    field = message.fields[name]
    bit = data.draw(st.integers(0, len(field) * 8 - 1))
    wrong = bytearray(field)
    wrong[bit // 8] ^= 1 << bit % 8
    changed = log.Canonical(message.stamp_ns, {**message.fields, name: bytes(wrong)})
    assert said.changed_field(topic, time_ns, changed) == name


@pytest.mark.parametrize('lost', [{'/tracks', '/ticks'}, {'/ticks'}])
def test_a_bag_without_its_end_is_not_the_same(run, tmp_path, lost):
    """What is written of the last five ticks is lost, the whole of it or the ticks alone."""

    def change(topic, number, data):
        return None if topic in lost and number >= TICKS - 5 else data

    verdict, _ = verify_bag(rewritten(run / 'bag', tmp_path / 'bag.mcap', change))
    assert verdict.is_fault
    assert verdict.first is None
    assert 'differs: the bag lacks 5 ticks whose tracks were written' in verdict.line()


def test_other_versions_are_no_fault_and_the_largest_difference_is_told(
    run, tmp_path, monkeypatch
):
    monkeypatch.setattr(log, 'provenance', lambda: {'numpy': '1.0', 'processor': 'vax F_FLOAT'})
    with BagReader(run / 'bag') as reader, BagWriter(tmp_path / 'bag') as writer:
        number = 0
        for topic, kind, data, time_ns in reader.serialized():
            if topic == '/tracks':
                number += 1
                data = flipped(data, 'x', 1, 4) if number in (11, 21) else data
                data = flipped(data, 'y', 1, 12) if number == 21 else data
            writer.write_copy(reader, topic, kind, data, time_ns)
    verdict, _ = verify_bag(tmp_path / 'bag')
    assert not verdict.is_fault
    assert not verdict.is_same
    assert (verdict.first.tick, verdict.largest.tick, verdict.largest.field) == (10, 20, 'y')
    assert verdict.line().startswith('not the same, as versions or processors differ; largest')
    assert 'numpy 1.0 there' in verdict.line()
    assert 'processor: F_FLOAT there, not here' in verdict.line()


def test_a_replay_goes_on_from_a_state(run):
    first, state = verify_bag(run, Replay(until_s=0.5))
    assert first.ticks == 13
    assert first.is_same
    assert first.stored is None
    second, _ = verify_bag(run, Replay(state=state))
    assert second.ticks == TICKS - 13
    assert second.is_same
    assert second.stored == second.digest


@pytest.mark.parametrize('state', [b'', b'PK', bytes(999)])
def test_what_is_no_state_is_refused(run, state):
    with pytest.raises(StateError, match='no state of a tracker'):
        verify_bag(run, Replay(state=state or b'x'))


def logged(ticks, config, cameras):
    """Return the hash of the tracks that come of ticks."""
    from mctrack_ros.codec import ros_from_message
    from mctrack_ros.fusion import open_fusion
    from mctrack_ros.recording import ROSBAGS_CLASSES

    tracker, digest = open_fusion(config, cameras), log.EMPTY
    for tick in ticks:
        tracks = tracker.step(tick).tracks
        message = ros_from_message(tracks, ROSBAGS_CLASSES, 'map')
        digest = log.chained(digest, tracks.stamp_ns, log.cloud_fields(message))
    return digest


@pytest.fixture(scope='module')
def messages(detections):
    """Return the site, and stamp, camera and rows of each message in order."""
    site = named_site('pitch5')
    with BagReader(detections) as reader:
        found = [
            (rows.stamp_ns, camera, rows)
            for camera in site.camera_names
            for rows, _ in reader.rows(f'/{camera}/detections', Detections)
        ]
    return site, sorted(found, key=lambda each: each[:2])


@settings(max_examples=12, deadline=None)
@given(rate=st.sampled_from([0.5, 1.0, 3.0, 100.0]), seed=st.integers(0, 2**32))
def test_arrivals_within_the_wait_may_be_in_any_order_and_at_any_rate(run, messages, rate, seed):
    """Of one camera they come in order, as DDS delivers them."""
    from mctrack_ros.fusion import open_batcher

    site, told = messages
    batching = site.fusion.batching
    wait_ns = round(batching.max_wait * batching.period * 1e9)
    random, arrivals, last = Random(seed), [], {}
    for stamp_ns, camera, rows in told:
        due_ns = round((stamp_ns - told[0][0]) / rate) + random.randrange(wait_ns)
        last[camera] = due_ns = max(due_ns, last.get(camera, 0) + 1)
        arrivals.append((due_ns, camera, rows))
    arrivals.sort(key=lambda each: each[0])
    batcher = open_batcher(site.fusion, site.camera_names)
    ticks = [tick for now, camera, rows in arrivals for tick in batcher.add(camera, rows, now)]
    ticks += batcher.flush()
    assert len(ticks) == TICKS
    assert logged(ticks, site.fusion, site.camera_names) == digest_of(run)


def digest_of(run):
    return log.StoredLog.of(attachments(run / 'bag')).hashes['/tracks'][1]
