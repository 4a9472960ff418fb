"""The recorder: nothing lost, and a finished bag whatever ends it."""

import signal
import subprocess
import sys

import pytest
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.interfaces import Detections
from mctrack_ros.recording import BagReader
from mctrack_ros.ros.messages import RCLPY_CLASSES
from mctrack_ros.ros.quality import latched, reliable
from mctrack_ros.ros.recorder import Recorder

pytestmark = pytest.mark.live


def cloud(stamp_ns):
    rows = Detections.build(stamp_ns, position=[[stamp_ns, 2.0, 0.0]])
    return cloud_from_rows(rows, RCLPY_CLASSES, 'map')


def recorded(path):
    with BagReader(path) as bag:
        return list(bag.messages())


@pytest.mark.parametrize('ending', [signal.SIGINT, signal.SIGTERM])
def test_interrupted_recorder_finishes_its_bag(bench, tmp_path, ending):
    bench.open()
    process = bench.spawn('recorder', path=str(tmp_path / 'bag'), topics=['/detections'])
    publisher = bench.publisher(PointCloud2, '/detections')
    heard = bench.messages(PointCloud2, '/detections')
    bench.until(lambda: publisher.get_subscription_count() == 2)
    for stamp_ns in range(50):
        publisher.publish(cloud(stamp_ns))
    bench.until(lambda: len(heard) == 50)
    process.send_signal(ending)
    assert bench.exit_code(process) == 0
    messages = recorded(tmp_path / 'bag')
    stamps = [rows_from_cloud(message, Detections).stamp_ns for _, message, _ in messages]
    assert stamps == list(range(50))
    assert '50 messages of 1 topics' in bench.log('recorder')


def test_topics_are_chosen_by_whole_names(bench, tmp_path):
    recorder = bench.make(
        Recorder, path=str(tmp_path / 'bag'), topics=['/cam./detections'], exclude='/cam2/.*'
    )
    names = ('/cam1/detections', '/cam2/detections', '/cam1/detections/more')
    publishers = [
        bench.observer.create_publisher(PointCloud2, name, reliable(10)) for name in names
    ]
    bench.until(lambda: publishers[0].get_subscription_count() == 1)
    for publisher in publishers:
        publisher.publish(cloud(1))
    bench.until(lambda: recorder.messages == 1)
    recorder.trigger_shutdown()
    assert [topic for topic, _, _ in recorded(tmp_path / 'bag')] == ['/cam1/detections']


def test_latched_topics_are_recorded_though_said_before(bench, tmp_path):
    bag = tmp_path / 'bag'
    bench.open('--params-file', str(bench.parameter_file('recorder', {'path': str(bag)})))
    site = bench.observer.create_publisher(String, '/site', latched())
    site.publish(String(data='said once'))
    recorder = bench.add(Recorder())
    bench.until(lambda: recorder.messages >= 1)
    recorder.trigger_shutdown()
    texts = [message.data for topic, message, _ in recorded(bag) if topic == '/site']
    assert texts == ['said once']


def test_a_bag_that_is_there_is_not_touched(bench, tmp_path, walker_bag):
    before = sorted(path.stat().st_mtime_ns for path in walker_bag.iterdir())
    process = bench.spawn('recorder', path=str(walker_bag))
    assert bench.exit_code(process) == 2
    assert 'exists already' in bench.log('recorder')
    assert sorted(path.stat().st_mtime_ns for path in walker_bag.iterdir()) == before


CRASHING = """
import sys
from mctrack_ros.ros.process import run
from mctrack_ros.ros.recorder import Recorder

class Crashing(Recorder):
    def report(self):
        if self.messages:
            raise KeyError('a mistake in the program')

    def look(self):
        super().look()
        self.drain()
        self.report()

sys.exit(run(Crashing))
"""


def test_a_crash_leaves_a_finished_bag(bench, tmp_path):
    bench.open()
    path = bench.parameter_file('crashing', {'path': str(tmp_path / 'bag'), 'topics': ['/d']})
    command = [sys.executable, '-c', CRASHING, '--ros-args', '--params-file', str(path)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        bench.processes.append(process)
        publisher = bench.publisher(PointCloud2, '/d')
        publisher.publish(cloud(1))
        bench.until(lambda: process.poll() is not None)
        assert 'a mistake in the program' in process.stderr.read()
    assert process.returncode == 1
    assert len(recorded(tmp_path / 'bag')) == 1


@pytest.mark.parametrize('explain', [False, True])
def test_explanations_are_recorded_if_asked(bench, tmp_path, explain):
    recorder = bench.make(Recorder, path=str(tmp_path / 'bag'), explain=explain)
    names = ['/cam1/detections', '/explanation/candidates', '/explanation/decisions']
    publishers = [
        bench.observer.create_publisher(PointCloud2, name, reliable(10)) for name in names
    ]
    bench.until(lambda: set(names) <= recorder.known if explain else names[0] in recorder.known)
    assert [each.get_subscription_count() for each in publishers] == [1, explain, explain]
