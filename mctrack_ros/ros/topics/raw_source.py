"""Subscriptions whose messages are taken in bulk, still serialised."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.subscription import Subscription
from rosbags.interfaces import Qos

from mctrack_ros.recording.bags.definitions import TypeDefinition


class Drained(CallbackGroup):
    """
    Subscriptions that the executor leaves alone.

    Their messages wait in DDS, with the time of their arrival, until a timer takes them all.
    Waiting on dozens of subscriptions for each message would cost several times as much.

    """

    def can_execute(self, entity: Any) -> bool:
        """Never."""
        return False

    def beginning_execution(self, entity: Any) -> bool:
        """Never."""
        return False

    def ending_execution(self, entity: Any) -> None:
        """Nothing began."""


@dataclass(slots=True)
class RawSource:
    """
    A topic that is recorded.

    Attributes
    ----------
    topic, kind : str
        Its name and its message type.
    definition : TypeDefinition
        Of that type.
    offered : list of Qos
        What its publishers offered when they were last looked at.
    subscription : Subscription
        What takes its messages.

    """

    topic: str
    kind: str
    definition: TypeDefinition
    offered: list[Qos]
    subscription: Subscription[Any]

    def take(self) -> tuple[bytes, int] | None:
        """Return the next message, serialised, and when it arrived (ns); None: there is none."""
        return take(self.subscription)


def take(subscription: Subscription[Any]) -> tuple[bytes, int] | None:
    """Return the next message of a raw subscription and when it arrived (ns); None: none."""
    with subscription.handle:
        taken = subscription.handle.take_message(subscription.msg_type, True)
    return None if taken is None else (taken[0], int(taken[1]['received_timestamp']))
