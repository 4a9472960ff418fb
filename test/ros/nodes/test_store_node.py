"""The store node: what the graph says is in the database, in order, whoever dies."""

import json
import signal
import time

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from mctrack_ros.codec import cloud_from_rows
from mctrack_ros.interfaces import EventCode, Events, Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.ros.nodes.store_node import StoreNode
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import latched
from mctrack_ros.store import Database, Run, events
from mctrack_ros.store.bags import write_bag

pytestmark = pytest.mark.live

BEGAN_NS = 1_700_000_000_000_000_000
TICK_NS = 40_000_000


def tracks(k):
    rows = Tracks.build(BEGAN_NS + k * TICK_NS, track_id=[1, 2], position=[[k, 0, 0], [0, k, 0]])
    return cloud_from_rows(rows, RCLPY_CLASSES, 'map')


def event(k, **columns):
    rows = Events.build(BEGAN_NS + k * TICK_NS, event=[EventCode.EXIT], **columns)
    return cloud_from_rows(rows, RCLPY_CLASSES, 'map')


def site(run):
    return String(data=json.dumps({'run': run, 'cameras': ['cam1']}))


def reported(seen):
    """Return what the node has reported of its store; its message by no name."""
    states = [state for message in seen for state in message.status]
    stores = [state for state in states if state.name.endswith(': store')]
    return [{'': one.message} | {each.key: each.value for each in one.values} for one in stores]


def stamps_of(path, run=''):
    with Run(path, run) as opened:
        return np.unique((opened.rows().stamp_ns - BEGAN_NS) // TICK_NS).tolist()


def test_what_the_graph_says_is_kept(bench, tmp_path):
    path = tmp_path / 'tracks.db'
    node = bench.make(StoreNode, database=str(path), site='hall')
    bench.observer.create_publisher(String, '/site', latched()).publish(site('r'))
    publishers = [
        bench.publisher(PointCloud2, topic) for topic in ('/tracks', '/events', '/cam1/events')
    ]
    seen = bench.messages(DiagnosticArray, '/diagnostics')
    for k in range(60):
        publishers[0].publish(tracks(k))
    publishers[1].publish(event(59, track_id=[2]))
    publishers[2].publish(event(59, local_id=[4], camera=[0]))
    bench.until(lambda: node.store.state.written >= 62)
    bench.until(lambda: {'writing', 'no data'} <= {each[''] for each in reported(seen)})
    last = reported(seen)[-1]
    assert (last['dropped'], last['waiting'], last['run']) == ('0', '0', 'r')
    assert last['database'] == 'there'
    node.trigger_shutdown()
    assert stamps_of(path) == list(range(60))
    with Run(path) as run:
        assert (run.site, run.cameras) == ('hall', ('cam1',))
        assert [each.track_id for each in events(run)] == [2]
    with Database(path) as database:
        write_bag(database, tmp_path / 'bag')
    with BagReader(tmp_path / 'bag') as bag:
        assert bag.topics.keys() == {'/site', '/tracks', '/events', '/cam1/events'}
        logged = [log_ns for _, _, log_ns in bag.messages(['/tracks'])]
    assert abs(logged[-1] - time.time_ns()) < 300e9


def test_a_killed_node_loses_half_a_second_at_most_and_the_next_goes_on(bench, tmp_path):
    path = tmp_path / 'tracks.db'
    bench.open()
    bench.observer.create_publisher(String, '/site', latched()).publish(site('r'))
    process = bench.spawn('store_node', database=str(path))
    publisher = bench.publisher(PointCloud2, '/tracks')
    seen = bench.messages(DiagnosticArray, '/diagnostics')
    sent = killed = 0
    began = time.monotonic()

    def send_until(condition):
        nonlocal sent
        while not condition():
            assert time.monotonic() - began < 120
            publisher.publish(tracks(sent))
            sent += 1
            bench.executor.spin_once(timeout_sec=0.0)
            time.sleep(max(began + sent * 0.04 - time.monotonic(), 0.0))

    send_until(lambda: sent == 70)
    process.send_signal(signal.SIGKILL)
    process.wait()
    killed = sent
    process = bench.spawn('store_node', database=str(path))
    seen.clear()
    send_until(lambda: any(int(each['received']) > 20 for each in reported(seen)))
    resumed = sent
    send_until(lambda: sent == resumed + 50)
    process.send_signal(signal.SIGTERM)
    assert bench.exit_code(process) == 0
    found = stamps_of(path, 'r')
    before = [k for k in found if k < killed]
    assert before == list(range(before[0], before[-1] + 1))
    assert killed - 1 - before[-1] <= 0.5 / 0.04
    after = [k for k in found if k >= killed]
    assert after == list(range(after[0], after[-1] + 1))
    assert after[0] < resumed
    assert after[-1] >= resumed + 40
    with Database(path) as database, database.connected() as connection:
        runs = connection.exec_driver_sql('SELECT name, ended_ns FROM runs').all()
    assert [tuple(row) for row in runs] == [('r', None)]


def test_a_database_with_a_password_is_refused(refusal):
    (line,) = refusal('store_node', database='postgresql://me:secret@/tracks')
    assert 'holds a password' in line
    assert 'secret' not in line
    assert "database is ''" in refusal('store_node')[0]
