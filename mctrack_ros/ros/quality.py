"""Quality of service of the graph's topics."""

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy


def reliable(depth: int) -> QoSProfile:
    """Return what all topics but images use: reliable, the last so many kept."""
    return QoSProfile(depth=depth)


def latched() -> QoSProfile:
    """Return what is said once and kept for those that come later."""
    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def images(is_reliable: bool, depth: int) -> QoSProfile:
    """Return the quality of a picture topic."""
    reliability = ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT
    return QoSProfile(depth=depth, reliability=reliability)
