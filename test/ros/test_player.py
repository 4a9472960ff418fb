"""The player: all of a bag, in its order, at its pace."""

import time

import pytest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CompressedImage

from mctrack_ros.codec import stamp_ns_of
from mctrack_ros.recording import BagReader
from mctrack_ros.ros.player import Player
from mctrack_ros.ros.quality import reliable

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
def test_every_picture_is_played_at_the_bags_pace(bench, walker_bag):
    began = time.monotonic()
    pictures, clock = play(bench, walker_bag)
    elapsed = time.monotonic() - began
    stamps = stamps_in(walker_bag)
    bench.until(lambda: len(pictures) == len(stamps))
    assert [stamp_ns_of(picture) for picture in pictures] == stamps
    assert elapsed >= (stamps[-1] - stamps[0]) * 1e-9
    times = [message.clock.sec * 10**9 + message.clock.nanosec for message in clock]
    assert times == sorted(times)
    assert len(times) > 100
    assert stamps[0] in times


@pytest.mark.live
def test_restamped_pictures_seem_captured_now_and_keep_their_phase(bench, walker_bag):
    before_ns = time.time_ns()
    pictures, clock = play(bench, walker_bag, restamp=True)
    stamps = stamps_in(walker_bag)
    bench.until(lambda: len(pictures) == len(stamps))
    moved = [stamp_ns_of(picture) for picture in pictures]
    shift_ns = moved[0] - stamps[0]
    assert moved == [stamp_ns + shift_ns for stamp_ns in stamps]
    assert shift_ns % 10**9 == 0
    assert before_ns <= moved[0] <= before_ns + 10 * 10**9
    assert clock == []


@pytest.mark.live
def test_part_of_a_bag_is_played(bench, walker_bag):
    pictures, _ = play(bench, walker_bag, start=1.0, duration=0.5, rate=10.0)
    stamps = [stamp_ns for stamp_ns in stamps_in(walker_bag)]
    bench.until(lambda: len(pictures) >= 13)
    assert stamp_ns_of(pictures[0]) == stamps[25]
    assert stamp_ns_of(pictures[-1]) == stamps[37]


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
def test_player_says_how_well_it_kept_time(bench, walker_bag):
    process = bench.spawn('player', path=str(walker_bag), wait=0.0, settle=0.0, rate=20.0)
    assert bench.exit_code(process) == 0
    assert 'too few listen to' in bench.log('player')
    assert 'played 100 messages: real-time factor' in bench.log('player')


@pytest.mark.live
def test_a_bag_cut_off_in_the_middle_ends_with_a_reason(bench, walker_bag):
    (data,) = walker_bag.glob('*.mcap')
    data.write_bytes(data.read_bytes()[: data.stat().st_size // 2])
    process = bench.spawn('player', path=str(walker_bag), wait=0.0, settle=0.0)
    assert bench.exit_code(process) in (1, 2)
    assert 'cannot be read' in bench.log('player')
    assert 'Traceback' not in bench.log('player')
