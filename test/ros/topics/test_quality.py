"""Quality of service from bags to publishers and back."""

import pytest
from rclpy.duration import Duration, Infinite
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import QosDurability, QosHistory, QosReliability, QosTime

from mctrack_ros.recording.bags.qos import reliable
from mctrack_ros.ros.topics.quality import from_bag, to_bag

LATCHED = reliable(3, latched=True)
PLAIN = reliable(10)
BEST_EFFORT = PLAIN._replace(reliability=QosReliability.BEST_EFFORT)
UNKNOWN = {'history': QosHistory.UNKNOWN, 'depth': 0}


def test_best_effort_stays_best_effort():
    profile = from_bag([BEST_EFFORT], 100, 1000)
    assert profile.reliability == ReliabilityPolicy.BEST_EFFORT
    assert profile.durability == DurabilityPolicy.VOLATILE
    assert profile.depth == 100


@pytest.mark.parametrize(
    ('offered', 'depth'),
    [
        ([LATCHED], 3),
        ([LATCHED._replace(**UNKNOWN)], 10),
        ([LATCHED._replace(**UNKNOWN)] * 12, 12),
    ],
)
def test_latched_topics_keep_what_their_publishers_kept(offered, depth):
    profile = from_bag(offered, 100, 1000)
    assert profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert profile.depth == depth


def test_whoever_heard_one_of_several_publishers_hears_the_player():
    timed = BEST_EFFORT._replace(deadline=QosTime(2, 0), lifespan=QosTime(1, 5))
    profile = from_bag([timed, LATCHED], 100, 1000)
    assert profile.reliability == ReliabilityPolicy.RELIABLE
    assert profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert profile.deadline == Duration(seconds=2)
    assert profile.lifespan == Infinite


@pytest.mark.parametrize('stated', [(9223372036, 854775807), (2147483647, 4294967295), (0, 0)])
def test_durations_without_end_are_known_in_every_spelling(stated):
    profile = from_bag([PLAIN._replace(deadline=QosTime(*stated))], 100, 1000)
    assert profile.deadline == Infinite


def test_unstated_policies_are_played_reliable_and_volatile():
    unknown = PLAIN._replace(
        reliability=QosReliability.UNKNOWN, durability=QosDurability.SYSTEM_DEFAULT, **UNKNOWN
    )
    profile = from_bag([unknown], 100, 1000)
    assert profile.reliability == ReliabilityPolicy.RELIABLE
    assert profile.durability == DurabilityPolicy.VOLATILE
    assert profile.history == HistoryPolicy.KEEP_LAST


@pytest.mark.parametrize(
    ('count', 'durability', 'depth'),
    [
        (1, DurabilityPolicy.TRANSIENT_LOCAL, 10),
        (10, DurabilityPolicy.TRANSIENT_LOCAL, 10),
        (11, DurabilityPolicy.VOLATILE, 100),
    ],
)
def test_without_recorded_quality_what_was_seldom_said_is_latched(count, durability, depth):
    profile = from_bag([], 100, count)
    assert profile.reliability == ReliabilityPolicy.RELIABLE
    assert (profile.durability, profile.depth) == (durability, depth)


def test_a_profile_survives_a_bag():
    profile = QoSProfile(
        depth=7,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        deadline=Duration(seconds=2, nanoseconds=7),
        lifespan=Infinite,
        liveliness_lease_duration=Infinite,
    )
    back = from_bag([to_bag(profile)], 1, 1000)
    for name in ('depth', 'reliability', 'durability', 'deadline', 'lifespan', 'history'):
        assert getattr(back, name) == getattr(profile, name), name
