"""A bench for nodes: a private ROS domain, an observer, waiting on conditions."""

import gc
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import pytest
import rclpy
import yaml
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import PointCloud2

from mctrack_ros.codec import compressed_message, jpeg_from_image, rows_from_cloud
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter
from mctrack_ros.resources import config_file
from mctrack_ros.ros.graph.supervise import BAD_CONFIGURATION
from mctrack_ros.ros.topics.quality import reliable
from ros_domains import free_domain
from walker import IMAGE_FROM_WORLD, PERIOD_NS, walker_image

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 90.0


@pytest.fixture
def domain():
    """Return a ROS domain that no other test on this machine uses now."""
    with free_domain() as number:
        yield number


@pytest.fixture
def bench(domain, tmp_path, monkeypatch):
    """Return a `Bench` that leaves nothing running."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
    monkeypatch.setenv('ROS_HOME', str(tmp_path / 'ros_home'))
    made = Bench(domain, tmp_path)
    yield made
    made.close()


class Bench:
    """Nodes under test, in this process or their own, and an observer of what they publish."""

    def __init__(self, domain, folder):
        self.domain, self.folder = domain, folder
        self.processes = []
        self.nodes = []
        self.executor = self.observer = None

    def open(self, *arguments):
        """Start ROS in this process with command-line arguments for the nodes made in it."""
        command = ['--ros-args', *arguments] if arguments else []
        rclpy.init(
            args=command, domain_id=self.domain, signal_handler_options=SignalHandlerOptions.NO
        )
        self.executor = SingleThreadedExecutor()
        self.observer = Node('observer', use_global_arguments=False)
        self.executor.add_node(self.observer)

    def make(self, kind, **parameters):
        """Make a node of a class in this process, with parameters, and activate it."""
        self.open('--params-file', str(self.parameter_file(kind.__name__, parameters)))
        return self.add(kind())

    def add(self, node):
        """Spin a node that was made, activate it if it is to start itself."""
        self.nodes.append(node)
        self.executor.add_node(node)
        if node.get_parameter('autostart').value:
            node.trigger_configure()
            assert not node.failure
            node.trigger_activate()
        return node

    def parameter_file(self, name, parameters):
        path = self.folder / f'{name}.yaml'
        path.write_text(yaml.safe_dump({'/**': {'ros__parameters': parameters}}))
        return path

    def spawn(self, node, *arguments, name=None, **parameters):
        """Start a node as a process; its output goes to a file."""
        name = name or node
        command = [sys.executable, '-X', 'faulthandler', '-m', f'mctrack_ros.ros.nodes.{node}']
        command += ['--ros-args', *arguments]
        command += ['-r', f'__node:={name}']
        if parameters:
            command += ['--params-file', str(self.parameter_file(name, parameters))]
        with open(self.folder / f'{name}.log', 'w') as log:
            process = subprocess.Popen(
                command, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )
        self.processes.append(process)
        return process

    def exit_code(self, process, patience_s=PATIENCE_S):
        """Wait until a process ends; one that does not says where it hangs and is a failure."""
        try:
            return process.wait(timeout=patience_s)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGABRT)
            process.wait()
            pytest.fail('\n'.join(path.read_text() for path in self.folder.glob('*.log')))

    def log(self, name):
        """Return what a process has said."""
        return (self.folder / f'{name}.log').read_text()

    def until(self, condition, patience_s=PATIENCE_S):
        """Spin until a condition holds, or fail."""
        end = time.monotonic() + patience_s
        while not condition():
            assert time.monotonic() < end, 'what was waited for did not happen'
            self.executor.spin_once(timeout_sec=0.02)

    def answer(self, send, received):
        """Send again until an answer comes: DDS may still be connecting nodes to each other."""
        before = len(received)
        while len(received) == before:
            send()
            end = time.monotonic() + 1.0
            self.until(lambda end=end: len(received) > before or time.monotonic() > end)

    def messages(self, kind, topic, quality=None):
        """Return a list that fills with a topic's messages."""
        received = []
        self.observer.create_subscription(kind, topic, received.append, quality or reliable(100))
        return received

    def rows(self, kind, topic):
        """Return a list that fills with the rows of a topic of clouds."""
        received = []
        self.observer.create_subscription(
            PointCloud2,
            topic,
            lambda message: received.append(rows_from_cloud(message, kind)),
            reliable(100),
        )
        return received

    def publisher(self, kind, topic, quality=None):
        """Return a publisher that already has a subscriber."""
        publisher = self.observer.create_publisher(kind, topic, quality or reliable(100))
        self.until(lambda: publisher.get_subscription_count() > 0)
        return publisher

    def heard(self, topic, count=1):
        """Wait until the observer's topic has a publisher."""
        self.until(lambda: self.observer.count_publishers(topic) >= count)

    def close(self):
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.wait()
        for node in self.nodes:
            if not node.ended:
                node.trigger_shutdown()
            node.destroy_node()
        self.nodes.clear()
        gc.collect()  # frees the services of lifecycles; after the shutdown DDS may wait forever
        if self.observer is not None:
            self.observer.destroy_node()
            rclpy.try_shutdown()


@pytest.fixture
def refusal(bench, monkeypatch, capfd):
    """Return a function that runs a node here, with wrong parameters, and gives what it says."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    monkeypatch.setenv('FASTRTPS_DEFAULT_PROFILES_FILE', str(config_file('fastdds.xml')))

    def run(node, **parameters):
        path = bench.parameter_file(node, parameters)
        monkeypatch.setattr(sys, 'argv', [node, '--ros-args', '--params-file', str(path)])
        assert import_module(f'mctrack_ros.ros.nodes.{node}').main() == BAD_CONFIGURATION
        output, errors = capfd.readouterr()
        return (output + errors).splitlines()

    yield run
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.fixture
def projection(tmp_path):
    """Return the calibration file of the walker's camera."""
    path = tmp_path / 'projection.yaml'
    path.write_text(yaml.safe_dump({'image_from_world': IMAGE_FROM_WORLD.tolist()}))
    return path


@pytest.fixture
def walker_bag(tmp_path):
    """Return a bag of two seconds of one walker in front of two cameras."""
    path = tmp_path / 'walker'
    start_ns = 1_700_000_000 * 10**9 + PERIOD_NS // 2
    with BagWriter(path) as writer:
        for index in range(50):
            stamp_ns = start_ns + index * PERIOD_NS
            for camera in ('cam1', 'cam2'):
                jpeg = jpeg_from_image(walker_image(index))
                message = compressed_message(
                    jpeg, ROSBAGS_CLASSES, stamp_ns, f'{camera}_optical_frame'
                )
                writer.write(f'/{camera}/image_raw/compressed', message, stamp_ns)
    return path
