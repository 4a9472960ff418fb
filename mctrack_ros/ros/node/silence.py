"""Says once which topic a node waits for, when nothing comes."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

PATIENCE_S = 5.0


def warn_of_silence(node: Node, topic: str, has_come: Callable[[], bool]) -> None:
    """
    Let a node warn if nothing has come for some seconds of real time from now.

    Parameters
    ----------
    node : Node
        Whose timer it is.
    topic : str
        What the node waits for, as it was subscribed to.
    has_come : callable
        Tells whether a message has come meanwhile.

    """

    def look() -> None:
        timer.cancel()
        if has_come():
            return
        name = node.resolve_topic_name(topic)
        count = node.count_publishers(name)
        reason = 'though it has a publisher' if count else 'nobody publishes it'
        node.get_logger().warning(f'waiting for {name}: nothing has come, {reason}')

    timer = node.create_timer(PATIENCE_S, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
