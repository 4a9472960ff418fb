"""The stream node: what fusion publishes reaches those who read."""

import json
import threading

import httpx
import pytest
from lxml import etree
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import Ticks
from mctrack_ros.ros.nodes.stream_node import StreamNode
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import latched, reliable
from mctrack_ros.store import Database, NewRun, TrajectoryWriter
from mctrack_ros.streams.formats.profiles import all_profiles
from stream_story import ABOUT, SITE, frames_of, stamp_ns, story

pytestmark = pytest.mark.live


class Fusion:
    """Publishes as fusion does."""

    def __init__(self, bench):
        node = bench.observer
        self.site = node.create_publisher(String, '/site', latched())
        self.clouds = {
            name: node.create_publisher(PointCloud2, f'/{name}', reliable(100))
            for name in ('tracks', 'events', 'ticks')
        }
        self.site.publish(String(data=json.dumps(SITE)))
        for cloud in self.clouds.values():
            bench.until(lambda cloud=cloud: cloud.get_subscription_count())

    def publish(self, tracks, events):
        """Publish what comes of a tick."""
        told = {'tracks': tracks, 'events': events, 'ticks': Ticks.build(tracks.stamp_ns)}
        for name, rows in told.items():
            if rows is not None:
                self.clouds[name].publish(cloud_from_rows(rows, RCLPY_CLASSES, 'map'))


def read(node, name, count):
    """Return what is read, in a thread of its own, until it holds so many frames."""
    found = []

    def reading():
        address = f'http://127.0.0.1:{node.server.port}/{name}'
        with httpx.stream('GET', address, timeout=60) as answer:
            text = ''
            for part in answer.iter_text():
                text += part
                if text.count('</frame>') == count:
                    break
        found.append(f'{text}</trajectories>')

    threading.Thread(target=reading, daemon=True).start()
    return found


def test_a_reader_reads_what_fusion_publishes_and_before_that_what_was_stored(bench, tmp_path):
    told = list(story())
    place = tmp_path / 'tracks.db'
    with (
        Database(place, create=True) as database,
        TrajectoryWriter(database, NewRun(ABOUT.run)) as writer,
    ):
        for tracks, events in told[:4]:
            writer.write_tracks(tracks)
            if events is not None:
                writer.write_events(events)
    node = bench.make(StreamNode, port=0, database=str(place))
    fusion = Fusion(bench)
    bench.until(lambda: node.hub.about.run == ABOUT.run)
    for tick in told[4:6]:
        fusion.publish(*tick)
    bench.until(lambda: node.assembler.stamp_ns is None and node.about == node.hub.about)
    found = read(node, f'tracks.xml?since={stamp_ns(0) - 1}', len(told))
    bench.until(lambda: node.hub.count)
    for tick in told[6:]:
        fusion.publish(*tick)
    bench.until(lambda: found)
    element = etree.fromstring(found[0].encode())
    assert element.get('run') == ABOUT.run
    profile = all_profiles()[0]
    expected = [profile.frame(frame).strip() for frame in frames_of(told)]
    stamps = [each.get('stamp_ns') for each in element]
    assert stamps == [str(stamp_ns(n)) for n in range(len(told))]
    body = found[0].splitlines()[2:-1]
    assert body == expected


def test_a_message_that_cannot_be_used_is_counted(bench):
    node = bench.make(StreamNode, port=0)
    fusion = Fusion(bench)
    fusion.clouds['tracks'].publish(PointCloud2())
    fusion.site.publish(String(data='no description'))
    bench.until(lambda: node.tracks_health.totals.get('refused') == 2)
    status = node.diagnostics._parts['readers'].report('readers')
    assert status.message == 'serving'


def test_no_log_shows_a_token(refusal, monkeypatch, tmp_path):
    kept = tmp_path / 'token'
    kept.write_text('for the stream\n')
    lines = refusal('stream_node', port=0, host='0.0.0.0', token_file=str(kept))
    assert 'expected at least 8 letters, digits' in lines[-1]
    monkeypatch.setenv('MCTRACK_STREAM_TOKEN', 'for-the-stream')
    lines += refusal('stream_node', port=0, host='192.0.2.7')
    assert '192.0.2.7:0 cannot be used' in lines[-1]
    assert not [line for line in lines if 'for the stream' in line or 'for-the-stream' in line]


def test_the_wrong_address_stops_the_node_with_a_line(bench):
    process = bench.spawn('stream_node', port=0, host='0.0.0.0')
    assert bench.exit_code(process) == 2
    assert 'MCTRACK_STREAM_TOKEN' in bench.log('stream_node')
