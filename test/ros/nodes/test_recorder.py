"""The recorder: nothing lost, and a finished bag whatever ends it."""

import json
import signal
import subprocess
import sys
import time

import pytest
import rclpy
import yaml
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Goals
from rcl_interfaces.srv import SetParameters
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosbags.interfaces import QosHistory
from sensor_msgs.msg import CompressedImage, Image, PointCloud2
from std_msgs.msg import String

from mctrack_ros.codec import cloud_from_rows, rows_from_cloud
from mctrack_ros.interfaces import Detections, Ticks
from mctrack_ros.recording import PARAMETERS, BagReader, attachments
from mctrack_ros.recording.track_log.log import RECORDING
from mctrack_ros.replay.proof.verify import verify_bag
from mctrack_ros.ros.nodes.fusion_node import FusionNode
from mctrack_ros.ros.nodes.recorder import Recorder
from mctrack_ros.ros.topics.choice import is_private
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import latched, reliable
from mctrack_ros.ros.topics.raw_source import Sequences
from mctrack_ros.site.description import site_description

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


@pytest.mark.parametrize('said', ['by a parameter', 'by the site', 'later'])
def test_no_picture_of_a_private_site_enters_a_bag(bench, tmp_path, capfd, said):
    bag, images = tmp_path / 'bag', ['/cam1/image_raw', '/driver/colour/compressed']
    private = {'private': True} if said == 'by a parameter' else {}
    parameters = bench.parameter_file('recorder', {'path': str(bag), **private})
    bench.open('--params-file', str(parameters))
    kinds = (Image, CompressedImage, PointCloud2)
    names = [*images, '/cam1/detections']
    publishers = [
        bench.observer.create_publisher(*each, reliable(10)) for each in zip(kinds, names)
    ]
    site = bench.observer.create_publisher(String, '/hall/site', latched())
    if said == 'by the site':
        site.publish(String(data='{"private": true}'))
    elif said == 'later':
        site.publish(String(data='{"run": "an earlier one"}'))
    recorder = bench.add(Recorder())
    if said == 'later':
        bench.until(lambda: publishers[0].get_subscription_count() == 1)
        site.publish(String(data='{"private": true}'))
    bench.until(lambda: set(images) <= recorder.left_out.keys())
    bench.until(lambda: publishers[2].get_subscription_count() == 1)
    for publisher, message in zip(publishers, (Image(), CompressedImage(), cloud(1))):
        publisher.publish(message)
    bench.until(lambda: '/cam1/detections' in recorder.sources and recorder.messages >= 1)
    recorder.trigger_shutdown()
    assert {topic for topic, _, _ in recorded(bag)} <= {'/cam1/detections', '/hall/site'}
    assert capfd.readouterr().err.count('/cam1/image_raw is not recorded: pictures') == 1


def test_what_is_no_private_site_hides_nothing():
    for text in ('', 'private', '[]', '{"private": 1}', '[' * 100_000, '{"private": false}'):
        assert not is_private(text)
    assert is_private(
        site_description({'origin': [0, 0], 'fusion': {}, 'private': True}, [], '', {})
    )


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
from mctrack_ros.ros.node.process import run
from mctrack_ros.recording.track_log.log import RECORDING
from mctrack_ros.replay.proof.verify import verify_bag
from mctrack_ros.ros.nodes.recorder import Recorder

class Crashing(Recorder):
    def report(self):
        if self.messages == 1:
            raise KeyError('a mistake in the program')

    def look(self):
        super().look()
        self.drain()
        self.report()

sys.exit(run(Crashing))
"""


def test_an_exception_ends_no_recording(bench, tmp_path):
    bench.open()
    path = bench.parameter_file('crashing', {'path': str(tmp_path / 'bag'), 'topics': ['/d']})
    command = [sys.executable, '-c', CRASHING, '--ros-args', '--params-file', str(path)]
    with open(tmp_path / 'log', 'w') as log:
        process = subprocess.Popen(command, stdout=log, stderr=log)
    bench.processes.append(process)
    publisher = bench.publisher(PointCloud2, '/d')
    publisher.publish(cloud(1))
    bench.until(lambda: 'a mistake in the program' in (tmp_path / 'log').read_text())
    publisher.publish(cloud(2))
    bench.until(lambda: publisher.wait_for_all_acked(Duration(seconds=0.1)))
    process.send_signal(signal.SIGINT)
    assert bench.exit_code(process) == 0
    assert len(recorded(tmp_path / 'bag')) == 2


@pytest.mark.parametrize('explain', [False, True])
def test_explanations_are_recorded_if_asked(bench, tmp_path, explain):
    recorder = bench.make(Recorder, path=str(tmp_path / 'bag'), explain=explain)
    names = ['/cam1/detections', '/explanation/candidates', '/explanation/decisions']
    publishers = [
        bench.observer.create_publisher(PointCloud2, name, reliable(10)) for name in names
    ]
    bench.until(
        lambda: set(names) <= recorder.sources.keys() if explain else names[0] in recorder.sources
    )
    assert [each.get_subscription_count() for each in publishers] == [1, explain, explain]


def test_a_type_that_rosbags_does_not_know_is_recorded_by_its_own_definition(bench, tmp_path):
    recorder = bench.make(Recorder, path=str(tmp_path / 'bag'))
    publishers = [bench.publisher(Goals, '/goals'), bench.publisher(PointCloud2, '/detections')]
    goal = PoseStamped()
    goal.pose.position.x = 3.5
    publishers[0].publish(Goals(goals=[goal]))
    publishers[1].publish(cloud(1))
    bench.until(lambda: recorder.messages == 2)
    assert not recorder.finished
    assert not recorder.left_out
    recorder.trigger_shutdown()
    by_topic = {topic: message for topic, message, _ in recorded(tmp_path / 'bag')}
    assert by_topic['/goals'].goals[0].pose.position.x == 3.5
    assert rows_from_cloud(by_topic['/detections'], Detections).stamp_ns == 1
    with BagReader(tmp_path / 'bag') as bag:
        definition = bag.definition('/goals')
        (offered,) = bag.offered('/goals')
    (info,) = bench.observer.get_publishers_info_by_topic('/goals')
    assert definition.type_hash == str(info.topic_type_hash)
    assert 'MSG: geometry_msgs/PoseStamped' in definition.text
    assert offered.history is QosHistory.UNKNOWN
    assert offered.deadline == (9223372036, 854775807)


def test_what_cannot_be_described_is_named_and_left_out(bench, tmp_path, capfd):
    recorder = bench.make(Recorder, path=str(tmp_path / 'bag'))
    bench.publisher(PointCloud2, '/detections').publish(cloud(1))
    bench.observer.create_publisher(String, '/both', reliable(10))
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=bench.domain)
    other = Node('other', context=context, use_global_arguments=False)
    other.create_publisher(PointCloud2, '/both', reliable(10))
    bench.until(lambda: recorder.left_out and recorder.messages == 1)
    assert 'several message types' in recorder.left_out['/both']
    other.destroy_node()
    rclpy.shutdown(context=context)
    recorder.trigger_shutdown()
    assert [topic for topic, _, _ in recorded(tmp_path / 'bag')] == ['/detections']
    log = capfd.readouterr().err
    assert log.count('/both is not recorded: it has several message types') == 1
    assert '1 messages of 1 topics, 0.0 MB; 1 left out: /both' in log


def test_who_publishes_later_and_with_best_effort_is_recorded_too(bench, tmp_path):
    recorder = bench.make(Recorder, path=str(tmp_path / 'bag'), topics=['/words'])
    bench.messages(String, '/words', latched())
    bench.until(lambda: bench.observer.count_subscribers('/words') == 1)
    recorder.look()
    said = bench.observer.create_publisher(String, '/words', latched())
    said.publish(String(data='before'))
    bench.until(lambda: recorder.messages == 1)
    best_effort = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    later = bench.observer.create_publisher(String, '/words', best_effort)
    bench.until(lambda: later.get_subscription_count() == 1)
    later.publish(String(data='later'))
    bench.until(lambda: recorder.messages == 2)
    recorder.trigger_shutdown()
    assert [message.data for _, message, _ in recorded(tmp_path / 'bag')] == ['before', 'later']


def test_what_lies_in_a_namespace_is_recorded_and_played_into_another(bench, tmp_path):
    bench.open()
    command = [sys.executable, '-m', 'mctrack_ros.cli.main']
    bag = str(tmp_path / 'bag')
    record = subprocess.Popen([*command, 'record', bag, '--namespace', 'hall'])
    bench.processes.append(record)
    names = ('/hall/words', '/hallway/words', '/words')
    publishers = [bench.observer.create_publisher(String, name, reliable(10)) for name in names]
    heard = bench.messages(String, '/hall/words')
    bench.until(lambda: publishers[0].get_subscription_count() == 2)
    for publisher in publishers:
        publisher.publish(String(data=publisher.topic_name))
    bench.until(lambda: heard)
    record.send_signal(signal.SIGINT)
    assert bench.exit_code(record) == 0
    assert [message.data for _, message, _ in recorded(bag)] == ['/hall/words']
    for publisher in publishers:
        bench.observer.destroy_publisher(publisher)
    for namespace, topic in (('/hall/', '/hall/words'), ('site', '/site/hall/words')):
        play = subprocess.Popen([*command, 'play', bag, '--namespace', namespace])
        bench.processes.append(play)
        said = bench.messages(String, topic)
        bench.until(lambda said=said: said)
        assert said[0].data == '/hall/words'
        assert bench.exit_code(play) == 0


@pytest.mark.parametrize(
    ('numbers', 'publishers', 'lost'),
    [
        ([7, 8, 9], 1, 0),
        ([7, 9, 12], 1, 3),
        ([7, 8, 1, 2], 1, 0),
        ([1, 1, 2, 2, 3, 3], 2, 0),
        ([50, 1, 51, 3, 52, 4], 2, 1),
        ([0, 0, 0], 1, 0),
    ],
)
def test_numbers_of_messages_tell_what_was_lost(numbers, publishers, lost):
    sequences = Sequences()
    for number in numbers:
        sequences.take(number, publishers)
    assert sequences.lost == lost


def test_what_was_lost_is_counted_and_a_failure(bench, tmp_path, capfd):
    recorder = bench.make(Recorder, path=str(tmp_path / 'bag'), topics=['/d'], depth=10)
    publisher = bench.publisher(PointCloud2, '/d')
    publisher.publish(cloud(0))
    bench.until(lambda: recorder.messages == 1)
    for stamp_ns in range(1, 51):
        publisher.publish(cloud(stamp_ns))
    bench.until(lambda: publisher.wait_for_all_acked(Duration(seconds=0.1)))
    bench.until(lambda: recorder.messages > 1)
    recorder.trigger_shutdown()
    count = json.loads(attachments(tmp_path / 'bag')[RECORDING])['/d']
    assert count['received'] + count['lost'] == 51
    assert count['lost'] > 0
    assert recorder.failure == f'messages were lost: /d {count["lost"]}'


def test_what_came_before_a_pause_counts(bench, tmp_path):
    recorder = bench.make(Recorder, path=str(tmp_path / 'bag'), topics=['/d'])
    publisher = bench.publisher(PointCloud2, '/d')
    publisher.publish(cloud(1))
    bench.until(lambda: recorder.messages == 1)
    recorder.trigger_deactivate()
    bench.until(lambda: not publisher.get_subscription_count())
    publisher.publish(cloud(2))
    recorder.trigger_activate()
    bench.until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(cloud(3))
    bench.until(lambda: recorder.messages == 2)
    recorder.trigger_shutdown()
    assert json.loads(attachments(tmp_path / 'bag')[RECORDING])['/d'] == {'received': 2, 'lost': 0}
    assert len(recorded(tmp_path / 'bag')) == 2


def test_a_disk_that_gets_full_ends_the_recording_cleanly(bench, tmp_path):
    recorder = bench.make(Recorder, path=str(tmp_path / 'bag'), topics=['/d'])
    bench.publisher(PointCloud2, '/d').publish(cloud(1))
    bench.until(lambda: recorder.messages == 1)
    object.__setattr__(recorder.config, 'min_free_mb', 1e12)
    bench.until(lambda: recorder.finished)
    assert 'are left on the disk' in recorder.failure
    recorder.trigger_shutdown()
    assert len(recorded(tmp_path / 'bag')) == 1


def test_a_recorded_graph_is_replayed_to_the_same_tracks(bench, tmp_path):
    bag, sent = tmp_path / 'bag', 60
    given = {'recorder': {'path': str(bag)}, 'fusion_node': {'cameras': ['one', 'two']}}
    path = tmp_path / 'parameters.yaml'
    path.write_text(
        yaml.safe_dump({name: {'ros__parameters': values} for name, values in given.items()})
    )
    bench.open('--params-file', str(path))
    recorder, fusion = bench.add(Recorder()), bench.add(FusionNode())
    outputs = (fusion.tracks, fusion.ticks, fusion.site)
    bench.until(lambda: all(each.get_subscription_count() for each in outputs))
    publishers = [bench.publisher(PointCloud2, f'/{name}/detections') for name in ('one', 'two')]
    bench.until(lambda: all(each.get_subscription_count() == 2 for each in publishers))
    begin_ns = 1_700_000_000 * 10**9
    for index in range(sent):
        for number, publisher in enumerate(publishers):
            stamp_ns = begin_ns + index * 40_000_000 + number * 1_000_000
            place = [[0.04 * index, 2.0, 0.0], [5.0, -0.02 * index, 0.0]]
            rows = Detections.build(
                stamp_ns, position=place, covariance=[[[0.01, 0.0], [0.0, 0.01]]] * 2
            )
            publisher.publish(cloud_from_rows(rows, RCLPY_CLASSES, 'map'))
            bench.executor.spin_once(timeout_sec=0.01)
    bench.until(lambda: '/ticks' in recorder.sources)
    bench.until(lambda: recorder.sources['/ticks'].received >= sent // 2)
    bench.until(lambda: b'/fusion_node' in (attached(recorder) or b''))
    recorder.trigger_shutdown()
    assert not recorder.failure
    verdict, _ = verify_bag(bag)
    assert verdict.is_same, verdict.line()
    assert verdict.ticks >= sent // 2
    assert verdict.compared == verdict.ticks
    parameters = attachments(bag)[PARAMETERS].decode()
    assert 'cameras:' in parameters


def test_a_graph_is_replayed_to_the_same_over_a_restart_of_fusion_and_another_threshold(
    bench, tmp_path
):
    bench.make(Recorder, path=str(tmp_path / 'bag'))
    (recorder,) = bench.nodes
    ticks, sites = bench.rows(Ticks, '/ticks'), bench.messages(String, '/site', latched())
    names, index = ('one', 'two'), 0
    publishers = [
        bench.observer.create_publisher(PointCloud2, f'/{name}/detections', 10) for name in names
    ]

    def walk():
        nonlocal index
        place = [[0.04 * index, 2.0, 0.0], [5.0, -0.02 * index, 0.0]]
        stamp_ns = 1_700_000_000 * 10**9 + index * 40_000_000
        rows = Detections.build(stamp_ns, position=place, covariance=[[[0.01, 0], [0, 0.01]]] * 2)
        index += 1
        for publisher in publishers:
            publisher.publish(cloud_from_rows(rows, RCLPY_CLASSES, 'map'))

    def heard(topic):
        return recorder.sources[topic].received if topic in recorder.sources else 0

    def follow():
        for _ in range(30):
            bench.answer(walk, ticks)

    for life in range(2):
        process = bench.spawn('fusion_node', cameras=list(names), resume=300.0)
        bench.until(lambda life=life: heard('/site') == len(sites) == 1 + 2 * life)
        listened = time.monotonic() + 1.0  # to /ticks, too
        bench.until(lambda listened=listened: time.monotonic() > listened)
        follow()
        parameter = Parameter(
            'fusion.management.report_time', value=0.3 + 0.1 * life
        ).to_parameter_msg()
        client = bench.observer.create_client(SetParameters, '/fusion_node/set_parameters')
        assert client.wait_for_service(30.0)
        answer = client.call_async(SetParameters.Request(parameters=[parameter]))
        bench.until(answer.done)
        assert answer.result().results[0].successful
        bench.until(lambda life=life: len(sites) == 2 + 2 * life)
        follow()
        process.send_signal(signal.SIGKILL)
        process.wait()
    bench.until(lambda: heard('/ticks') == len(ticks))
    recorder.trigger_shutdown()
    verdict, _ = verify_bag(tmp_path / 'bag')
    assert verdict.is_same, verdict.line()
    assert verdict.compared == verdict.ticks == len(ticks)


def attached(recorder):
    recorder.writer.flush()
    return attachments(recorder.config.path).get(PARAMETERS)
