"""Subscriptions whose messages are taken in bulk, still serialised."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from rclpy.callback_groups import CallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rosbags.interfaces import Qos

from mctrack_ros.recording.bags.definitions import TypeDefinition


class _Drained(CallbackGroup):
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


class Sequences:
    """
    Tells by the numbers that publishers give their messages how many were lost.

    Messages do not say which publisher of a topic they are of: a number is the next one of who
    is nearest before it. What came before the first message is not counted.

    Attributes
    ----------
    lost : int
        Messages that did not come.

    """

    def __init__(self) -> None:
        self.lost = 0
        self._last: list[int] = []

    def take(self, number: int, publishers: int) -> None:
        """Note a message's number, 0: it has none; and how many publish now."""
        if number <= 0:
            return
        before = [last for last in self._last if last < number]
        if before and (max(before) == number - 1 or len(self._last) >= publishers):
            self.lost += number - max(before) - 1
            self._last.remove(max(before))
        elif len(self._last) >= publishers:
            self._last.remove(min(self._last))  # its publisher began again
        self._last.append(number)


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
    sequences : Sequences
        Which did not come.
    received : int
        How many came.

    """

    topic: str
    kind: str
    definition: TypeDefinition
    offered: list[Qos]
    subscription: Subscription[Any]
    sequences: Sequences = field(default_factory=Sequences)
    received: int = 0

    def take(self) -> tuple[bytes, int] | None:
        """Return the next message, serialised, and when it arrived (ns); None: there is none."""
        taken = take(self.subscription)
        if taken is None:
            return None
        self.received += 1
        self.sequences.take(taken.number, max(len(self.offered), 1))
        return taken.data, taken.received_ns

    def counts(self) -> dict[str, int]:
        """Return how many messages came, and how many did not."""
        return {'received': self.received, 'lost': self.sequences.lost}


def subscribe_raw(node: Node, kind: Any, topic: str, quality: QoSProfile) -> Subscription[Any]:
    """Return a subscription whose messages wait until they are taken, serialised."""
    return node.create_subscription(
        kind,
        topic,
        lambda _: None,
        quality,
        callback_group=_Drained(),
        event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        raw=True,
    )


class Taken(NamedTuple):
    """A message, serialised; when it arrived, ns; its publisher's number of it, 0: none."""

    data: bytes
    received_ns: int
    number: int


def take(subscription: Subscription[Any]) -> Taken | None:
    """Return the next message of a raw subscription; None: there is none."""
    with subscription.handle:
        taken = subscription.handle.take_message(subscription.msg_type, True)
    if taken is None:
        return None
    data, info = taken
    received_ns, number = info['received_timestamp'], info['publication_sequence_number']
    return Taken(data, int(received_ns), number or 0)
