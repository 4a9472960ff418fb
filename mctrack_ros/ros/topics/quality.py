"""Quality of service of the graph's topics."""

from collections.abc import Sequence

from rclpy.duration import Duration, Infinite
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)

_LATCHED = DurabilityPolicy.TRANSIENT_LOCAL
_LONGEST_S = 2147483647
"""From so many seconds on a duration of a bag has no end; implementations of DDS differ in it."""

_REPLAYED_DEPTH = 10
"""Messages that a latched topic keeps whose depth nobody knows, as rosbag2 does."""


def reliable(depth: int) -> QoSProfile:
    """Return what all topics but images use: reliable, the last so many kept."""
    return QoSProfile(depth=depth)


def latched() -> QoSProfile:
    """Return what is said once and kept for those that come later."""
    return QoSProfile(depth=1, durability=_LATCHED)


def images(is_reliable: bool, depth: int) -> QoSProfile:
    """Return the quality of an image topic."""
    reliability = ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT
    return QoSProfile(depth=depth, reliability=reliability)


def to_bag(profile: QoSProfile) -> Qos:
    """Return a publisher's quality as bags state it; DDS has neither history nor depth."""
    return Qos(
        history=QosHistory(int(profile.history)),
        depth=profile.depth,
        reliability=QosReliability(int(profile.reliability)),
        durability=QosDurability(int(profile.durability)),
        deadline=_time(profile.deadline),
        lifespan=_time(profile.lifespan),
        liveliness=QosLiveliness(int(profile.liveliness)),
        liveliness_lease_duration=_time(profile.liveliness_lease_duration),
        avoid_ros_namespace_conventions=profile.avoid_ros_namespace_conventions,
    )


def from_bag(offered: Sequence[Qos], depth: int, count: int) -> QoSProfile:
    """
    Return the quality that a recorded topic is played with.

    Whoever could hear one of the recorded publishers hears the player. Where none was recorded
    the topic is reliable, and latched if so few messages were said that all can be kept.

    Parameters
    ----------
    offered : sequence of Qos
        Of the recorded publishers.
    depth : int
        How many messages may queue at least; a latched topic keeps as many as it did.
    count : int
        How many messages the topic holds.

    """
    if not offered:
        few = count <= _REPLAYED_DEPTH
        return QoSProfile(depth=_REPLAYED_DEPTH, durability=_LATCHED) if few else reliable(depth)
    best_effort = all(each.reliability is QosReliability.BEST_EFFORT for each in offered)
    is_latched = any(each.durability is QosDurability.TRANSIENT_LOCAL for each in offered)
    stated = max(each.depth if each.history is QosHistory.KEEP_LAST else 0 for each in offered)
    manual = any(each.liveliness is QosLiveliness.MANUAL_BY_TOPIC for each in offered)
    keeps_all = any(each.history is QosHistory.KEEP_ALL for each in offered)
    if is_latched:
        depth = stated or max(_REPLAYED_DEPTH, len(offered))
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL if keeps_all else HistoryPolicy.KEEP_LAST,
        depth=max(stated, depth),
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=_LATCHED if is_latched else DurabilityPolicy.VOLATILE,
        deadline=min(_duration(each.deadline) for each in offered),
        lifespan=max(_duration(each.lifespan) for each in offered),
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC if manual else LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=min(
            _duration(each.liveliness_lease_duration) for each in offered
        ),
    )


def _time(duration: Duration) -> QosTime:
    return QosTime(*divmod(duration.nanoseconds, 10**9))


def _duration(time: QosTime) -> Duration:
    """Return a duration; none that was stated has no end."""
    if time.sec >= _LONGEST_S or not (time.sec or time.nsec):
        return Infinite
    return Duration(seconds=time.sec, nanoseconds=time.nsec)
