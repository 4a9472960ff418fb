"""The player: all of a bag, in its order, at its pace."""

import os
import re
import sys
import time
from dataclasses import field, make_dataclass
from types import ModuleType

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import String
from std_srvs.srv import Trigger

from mctrack_ros.codec import stamp_ns_of
from mctrack_ros.recording import BagReader, BagWriter
from mctrack_ros.ros.nodes.player import Player
from mctrack_ros.ros.nodes.recorder import Recorder
from mctrack_ros.ros.topics.quality import latched, reliable

TOPICS = ['/cam1/image_raw/compressed', '/cam2/image_raw/compressed']


def stamps_in(bag):
    with BagReader(bag) as reader:
        return [stamp_ns_of(message) for _, message, _ in reader.messages(TOPICS[:1])]


def play(bench, bag, **parameters):
    """Play with a subscriber on each topic; return the first's messages once it is done."""
    parameters = {'path': str(bag), 'settle': 0.0, 'wait': 10.0} | parameters
    bench.open('--params-file', str(bench.parameter_file('player', parameters)))
    first, _ = (bench.messages(CompressedImage, topic, reliable(200)) for topic in TOPICS)
    clock = bench.messages(Clock, '/clock', reliable(1000))
    player = bench.add(Player())
    bench.until(lambda: player.finished)
    return first, clock


@pytest.mark.live
def test_every_image_is_played_at_the_bags_pace(bench, walker_bag):
    began = time.monotonic()
    images, clock = play(bench, walker_bag)
    elapsed = time.monotonic() - began
    stamps = stamps_in(walker_bag)
    bench.until(lambda: len(images) == len(stamps))
    assert [stamp_ns_of(image) for image in images] == stamps
    assert elapsed >= (stamps[-1] - stamps[0]) * 1e-9
    times = [message.clock.sec * 10**9 + message.clock.nanosec for message in clock]
    assert times == sorted(times)
    assert len(times) > 100
    assert stamps[0] in times


@pytest.mark.live
def test_restamped_images_seem_captured_now_and_keep_their_phase(bench, walker_bag):
    before_ns = time.time_ns()
    images, clock = play(bench, walker_bag, restamp=True)
    stamps = stamps_in(walker_bag)
    bench.until(lambda: len(images) == len(stamps))
    moved = [stamp_ns_of(image) for image in images]
    shift_ns = moved[0] - stamps[0]
    assert moved == [stamp_ns + shift_ns for stamp_ns in stamps]
    assert shift_ns % 10**9 == 0
    assert before_ns <= moved[0] <= before_ns + 10 * 10**9
    assert clock == []


@pytest.mark.live
def test_part_of_a_bag_is_played(bench, walker_bag):
    images, _ = play(bench, walker_bag, start=1.0, duration=0.5, rate=10.0)
    stamps = [stamp_ns for stamp_ns in stamps_in(walker_bag)]
    bench.until(lambda: len(images) >= 13)
    assert stamp_ns_of(images[0]) == stamps[25]
    assert stamp_ns_of(images[-1]) == stamps[37]


@pytest.mark.live
def test_a_stopped_player_waits_and_then_plays_from_the_beginning(bench, walker_bag):
    given = {'path': str(walker_bag), 'settle': 0.0, 'rate': 0.5}
    bench.open('--params-file', str(bench.parameter_file('player', given)))
    first, _ = (bench.messages(CompressedImage, topic, reliable(200)) for topic in TOPICS)
    player = bench.add(Player())
    bench.until(lambda: len(first) > 3)
    player.trigger_deactivate()
    assert not player.finished
    first.clear()
    player.trigger_activate()
    bench.until(lambda: first)
    assert stamp_ns_of(first[0]) == stamps_in(walker_bag)[0]
    player.trigger_deactivate()
    assert not player.finished
    assert not player.failure


@pytest.mark.live
def test_playing_begins_when_all_listen(bench, walker_bag):
    parameters = {'path': str(walker_bag), 'settle': 0.0, 'rate': 100.0}
    bench.open('--params-file', str(bench.parameter_file('player', parameters)))
    first = bench.messages(CompressedImage, TOPICS[0], reliable(200))
    player = bench.add(Player())
    bench.until(lambda: player.played[TOPICS[0]].publisher.get_subscription_count() == 1)
    assert not first
    second = bench.messages(CompressedImage, TOPICS[1], reliable(200))
    bench.until(lambda: len(first) == len(second) == 50)


@pytest.mark.live
def test_topics_that_others_publish_are_warned_of_once(bench, walker_bag, capfd):
    parameters = {'path': str(walker_bag), 'settle': 0.0, 'rate': 100.0}
    bench.open('--params-file', str(bench.parameter_file('player', parameters)))
    bench.observer.create_publisher(CompressedImage, TOPICS[1], reliable(10))
    heard = [bench.messages(CompressedImage, topic, reliable(200)) for topic in TOPICS]
    player = bench.add(Player())
    bench.until(lambda: player.finished and all(heard))
    (line,) = [line for line in capfd.readouterr().err.splitlines() if '--topic' in line]
    assert f'others publish {TOPICS[1]}, too' in line


@pytest.mark.live
def test_diagnostics_say_what_it_waits_for_and_how_it_plays(bench, walker_bag):
    parameters = {'path': str(walker_bag), 'settle': 0.0, 'wait': 60.0, 'loop': True}
    bench.open('--params-file', str(bench.parameter_file('player', parameters)))
    reports = bench.messages(DiagnosticArray, '/diagnostics', reliable(10))
    bench.add(Player())

    def is_said(message):
        said = [each for report in reports for each in report.status]
        return any(each.name == '/player: playing' and each.message == message for each in said)

    bench.until(lambda: is_said('waiting for subscribers'))
    for topic in TOPICS:
        bench.messages(CompressedImage, topic, reliable(200))
    bench.until(lambda: is_said('playing'))


@pytest.mark.live
def test_player_says_how_well_it_kept_time(bench, walker_bag):
    process = bench.spawn('player', path=str(walker_bag), wait=0.0, settle=0.0, rate=20.0)
    assert bench.exit_code(process) == 0
    assert 'too few subscribe to' in bench.log('player')
    assert 'played 100 messages: real-time factor' in bench.log('player')


@pytest.mark.live
def test_a_cut_bag_is_played_up_to_the_cut_and_says_until_when(bench, walker_bag):
    (data,) = walker_bag.glob('*.mcap')
    data.write_bytes(data.read_bytes()[: data.stat().st_size // 2])
    process = bench.spawn('player', path=str(data), wait=0.0, settle=0.0, rate=20.0)
    assert bench.exit_code(process) == 0
    assert len(re.findall('breaks off: it is read until', bench.log('player'))) == 1
    count = int(re.search('played ([0-9]+) messages', bench.log('player'))[1])
    assert 40 <= count <= 60


@pytest.mark.live
def test_nobody_is_waited_for_who_listens_to_what_is_not_played(bench, walker_bag):
    bench.open()
    bench.observer.create_publisher(CompressedImage, '/cam9/image_raw/compressed', reliable(10))
    process = bench.spawn(
        'player', path=str(walker_bag), topics=['/words'], settle=0.0, wait=3600.0
    )
    assert bench.exit_code(process) == 2
    with BagWriter(bench.folder / 'words') as writer:
        writer.write_text('/words', 'hello', 0)
    process = bench.spawn('player', path=str(bench.folder / 'words'), settle=0.0, wait=3600.0)
    assert bench.exit_code(process) == 0
    assert 'waiting' not in bench.log('player')


@pytest.mark.live
def test_player_says_at_once_what_it_waits_for(bench, walker_bag):
    bench.open()
    bench.messages(CompressedImage, TOPICS[0], reliable(200))
    wait_for = ['.*/image_raw(/compressed)?', '/nowhere 1']
    bench.spawn('player', path=str(walker_bag), settle=0.0, wait=3600.0, wait_for=wait_for)
    bench.until(lambda: 'waiting up to' in bench.log('player'))
    (line,) = [line for line in bench.log('player').splitlines() if 'waiting up to' in line]
    assert TOPICS[1] in line
    assert '/nowhere' in line


PROFILES = {
    'latched': QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL),
    'best effort': QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT),
    'timed': QoSProfile(
        depth=10,
        deadline=Duration(seconds=2),
        lifespan=Duration(seconds=5, nanoseconds=500),
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
        liveliness_lease_duration=Duration(seconds=3),
    ),
}


def offered_by(node, topic):
    """Return what the only publisher of a topic offers, as discovery tells it."""
    (info,) = node.get_publishers_info_by_topic(topic)
    profile = info.qos_profile
    return [
        *(profile.reliability, profile.durability, profile.liveliness),
        *(profile.deadline, profile.lifespan, profile.liveliness_lease_duration),
    ]


@pytest.mark.live
@pytest.mark.parametrize('name', PROFILES)
def test_what_was_recorded_is_played_with_the_quality_of_its_publishers(bench, tmp_path, name):
    bag = tmp_path / 'bag'
    recorder = bench.make(Recorder, path=str(bag), topics=['/map'])
    publisher = bench.publisher(OccupancyGrid, '/map', PROFILES[name])
    publisher.publish(OccupancyGrid(data=[1, 2, 3]))
    bench.until(lambda: recorder.messages == 1)
    before = offered_by(bench.observer, '/map')
    recorder.trigger_shutdown()
    bench.observer.destroy_publisher(publisher)
    process = bench.spawn('player', path=str(bag), loop=True, wait=0.0, settle=0.0)
    bench.until(lambda: bench.observer.count_publishers('/map') == 1)
    assert offered_by(bench.observer, '/map') == before
    process.kill()


@pytest.mark.live
def test_a_latched_map_reaches_who_comes_late(bench, tmp_path):
    bag = tmp_path / 'bag'
    recorder = bench.make(Recorder, path=str(bag), topics=['/map', '/tick'])
    publishers = [
        bench.publisher(OccupancyGrid, '/map', latched()),
        bench.publisher(OccupancyGrid, '/tick', reliable(10)),
    ]
    for publisher in publishers:
        publisher.publish(OccupancyGrid(data=[1, 2, 3]))
    bench.until(lambda: recorder.messages == 2)
    first = time.monotonic()
    bench.until(lambda: time.monotonic() > first + 1.0)
    publishers[1].publish(OccupancyGrid())
    bench.until(lambda: recorder.messages == 3)
    recorder.trigger_shutdown()
    for publisher in publishers:
        bench.observer.destroy_publisher(publisher)
    bench.spawn('player', path=str(bag), wait=0.0, settle=0.0, rate=0.01)
    clock = bench.messages(Clock, '/clock', reliable(1000))
    bench.until(lambda: len(clock) > 50)
    late = bench.messages(OccupancyGrid, '/map', latched())
    bench.until(lambda: late)
    assert list(late[0].data) == [1, 2, 3]


def words_bag(path, items):
    """Write a bag of texts: topic, log time (ns), text."""
    with BagWriter(path) as writer:
        for topic, time_ns, text in items:
            writer.write_text(topic, text, time_ns)
    return path


@pytest.mark.live
def test_equal_stamps_come_in_the_order_of_topics_under_other_names_but_for_the_excluded(
    bench, tmp_path
):
    items = [(f'/{topic}', time_ns, topic) for time_ns in (5, 7) for topic in 'dbca']
    bag = words_bag(tmp_path / 'bag', items)
    parameters = {
        'path': str(bag),
        'settle': 0.0,
        'wait_for': ['/.* 1'],
        'exclude': '/c',
        'remap': ['/a:=/z'],
    }
    bench.open('--params-file', str(bench.parameter_file('player', parameters)))
    heard = [bench.messages(String, f'/{topic}') for topic in 'zbcd']
    player = bench.add(Player())
    bench.until(lambda: player.finished)
    bench.until(lambda: [len(each) for each in heard] == [2, 2, 0, 2])
    assert [each[0] for each in player.messages(0)] == ['/a', '/b', '/d'] * 2


@pytest.mark.live
def test_a_player_is_paused_stepped_and_moved_by_services_parameters_and_keys(bench, tmp_path):
    items = [('/words', index * 10**8, str(index)) for index in range(100)]
    bag = words_bag(tmp_path / 'bag', items)
    parameters = {'path': str(bag), 'settle': 0.0, 'paused': True, 'burst': 3, 'wait': 0.0}
    bench.open('--params-file', str(bench.parameter_file('player', parameters)))
    heard = bench.messages(String, '/words')
    player = bench.add(Player())
    bench.until(lambda: player.played['/words'].publisher.get_subscription_count() == 1)

    def ask(name):
        client = bench.observer.create_client(Trigger, f'/player/{name}')
        bench.until(client.service_is_ready)
        answer = client.call_async(Trigger.Request())
        bench.until(answer.done)
        assert answer.result().success

    def said():
        return [message.data for message in heard]

    bench.until(lambda: player.count == 0 and player.thread.is_alive())
    ask('play_next')
    bench.until(lambda: said() == ['0'])
    ask('burst')
    bench.until(lambda: said() == ['0', '1', '2', '3'])
    player.controls.press('n')
    bench.until(lambda: len(heard) == 5)
    for _ in range(2):  # each time it is set it jumps
        assert player.set_parameters([Parameter('position', value=9.5)])[0].successful
        assert player.get_parameter('position').value == -1.0
        ask('play_next')
        bench.until(lambda: said()[5:] and set(said()[5:]) == {'95'})
    assert player.set_parameters([Parameter('rate', value=100.0)])[0].successful
    assert not player.set_parameters([Parameter('loop', value=True)])[0].successful
    player.controls.press('+')
    assert player.transport.rate == pytest.approx(110.0)
    ask('toggle_paused')
    bench.until(lambda: player.finished)
    bench.until(lambda: said() == [str(index) for index in (*range(5), 95, *range(95, 100))])


SERVICES = {
    'Burst': ({'num_messages': int}, {'actually_burst': int}),
    'GetRate': ({}, {'rate': float}),
    'IsPaused': ({}, {'paused': bool}),
    'Pause': ({}, {}),
    'PlayNext': ({}, {'success': bool}),
    'Resume': ({}, {}),
    'Seek': ({'time': Time}, {'success': bool}),
    'SetRate': ({'rate': float}, {'success': bool}),
    'TogglePaused': ({}, {}),
}
"""Fields of requests and responses as rosbag2_interfaces of Jazzy defines them."""


@pytest.fixture
def rosbag2(monkeypatch):
    """
    Return a player that is asked by classes with the fields of rosbag2's services.

    The wheels lack rosbag2_interfaces, and DDS takes no service without type support: the
    callbacks that the player offers are called as rclpy calls them.
    """
    stood_in, offered = ModuleType('rosbag2_interfaces.srv'), {}
    for name, fields in SERVICES.items():
        parts = [
            make_dataclass(
                part, [(*each, field(default_factory=each[1])) for each in named.items()]
            )
            for part, named in zip(('Request', 'Response'), fields)
        ]
        setattr(stood_in, name, type(name, (), dict(zip(('Request', 'Response'), parts))))
    monkeypatch.setitem(sys.modules, 'rosbag2_interfaces', ModuleType('rosbag2_interfaces'))
    monkeypatch.setitem(sys.modules, 'rosbag2_interfaces.srv', stood_in)

    class Asked(Player):
        def create_service(self, kind, name, callback, **options):
            if kind not in vars(stood_in).values():
                return super().create_service(kind, name, callback, **options)
            offered[name] = kind, callback
            return None

        def ask(self, name, **fields):
            kind, callback = offered[f'~/{name}']
            return callback(kind.Request(**fields), kind.Response())

    return Asked


def open_paused(bench, tmp_path, kind, begin_s, **parameters):
    """Open a paused player of hundred words, 0.1 s apart; return it and what is heard."""
    begin_ns = round(begin_s * 1e9)
    items = [('/words', begin_ns + index * 10**8, str(index)) for index in range(100)]
    bag = words_bag(tmp_path / 'bag', items)
    parameters = {'path': str(bag), 'settle': 0.0, 'paused': True, 'wait': 0.0} | parameters
    bench.open('--params-file', str(bench.parameter_file('player', parameters)))
    heard = bench.messages(String, '/words')
    player = bench.add(kind())
    bench.until(lambda: player.played['/words'].publisher.get_subscription_count() == 1)
    return player, lambda: [int(message.data) for message in heard]


@pytest.mark.live
def test_rosbag2s_seek_goes_to_an_absolute_time_or_says_why_not(bench, tmp_path, rosbag2, capfd):
    player, said = open_paused(bench, tmp_path, rosbag2, 1.7e9, start=2.0, duration=6.0)
    assert player.ask('seek', time=Time(sec=1_700_000_005, nanosec=100_000_000)).success
    assert player.ask('play_next').success
    assert player.ask('seek', time=Time(sec=1_700_000_002)).success
    assert player.ask('play_next').success
    bench.until(lambda: said() == [51, 20])
    for second in (3, 1_700_000_001, 1_700_000_009):
        assert not player.ask('seek', time=Time(sec=second)).success
    player.set_parameters([Parameter('position', value=9.0)])
    logged = capfd.readouterr().err
    assert 'no jump to 3.000000000 s: what is played of the bag lasts from' in logged
    assert 'from 1700000002.000000000 to 1700000008.000000000 s' in logged
    assert logged.count('no jump to') == 4
    assert player.ask('play_next').success
    assert player.ask('seek', time=Time(sec=1_700_000_008)).success
    assert player.ask('play_next').success
    bench.until(lambda: player.finished and said() == [51, 20, 21, 80])


@pytest.mark.live
def test_rosbag2s_burst_says_how_many_messages_went(bench, tmp_path, rosbag2):
    player, said = open_paused(bench, tmp_path, rosbag2, 0.0, loop=True)
    assert player.ask('burst', num_messages=7).actually_burst == 7
    bench.until(lambda: said() == [*range(7)])
    player.ask('resume')
    assert not player.transport.is_paused
    assert not player.ask('play_next').success
    assert player.ask('burst', num_messages=3).actually_burst == 0
    player.ask('toggle_paused')
    assert player.transport.is_paused


@pytest.mark.live
def test_rosbag2s_burst_of_0_is_of_the_whole_bag(bench, tmp_path, rosbag2):
    player, said = open_paused(bench, tmp_path, rosbag2, 0.0)
    assert player.ask('burst').actually_burst == 100
    bench.until(lambda: player.finished and said() == [*range(100)])
    assert not player.ask('play_next').success


@pytest.mark.live
def test_rosbag2s_set_rate_sets_the_parameter_and_refuses_what_is_no_speed(
    bench, tmp_path, rosbag2, capfd
):
    player, _ = open_paused(bench, tmp_path, rosbag2, 0.0)
    assert player.ask('set_rate', rate=2.5).success
    for rate in (0.0, -1.0, float('nan'), float('inf'), 1e9):
        assert not player.ask('set_rate', rate=rate).success
    assert player.transport.rate == player.get_parameter('rate').value == 2.5
    assert player.ask('get_rate').rate == 2.5
    assert player.ask('is_paused').paused
    player.ask('resume')
    assert not player.ask('is_paused').paused
    assert capfd.readouterr().err.count('the speed stays: ') == 5


@pytest.mark.live
def test_arrow_keys_jump_five_seconds_within_what_is_played(bench, tmp_path, monkeypatch):
    read_end, write_end = os.pipe()
    with open(read_end) as pipe, open(write_end, 'wb', buffering=0) as pressed:
        monkeypatch.setattr(sys, 'stdin', pipe)
        player, said = open_paused(bench, tmp_path, Player, 1.7e9, start=1.0)
        bench.until(lambda: player.transport.next_ns)
        words = []
        for keys, word in (
            (b'n', 10),
            (b'\x1b[Cn', 60),
            (b'\x1bODn', 10),  # as keypads say it
            (b'\x1b[1;5C\x1b[A\x1b[15~n', 60),  # with Ctrl; up and F5 are no keys here
            (b'\x1b[D\x1b[Dn', 10),
            (b'\x1bn', 11),
            (b'\x1b[C\x1b[Cn', 99),
        ):
            pressed.write(keys)
            words.append(word)
            bench.until(lambda: said() == words)
        bench.until(lambda: player.finished)
