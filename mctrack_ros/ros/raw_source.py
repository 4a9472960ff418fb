"""Subscriptions whose messages are taken in bulk, still serialised."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.subscription import Subscription


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


@dataclass(frozen=True, slots=True)
class RawSource:
    """A topic that is recorded, with the name of its message type."""

    topic: str
    kind: str
    subscription: Subscription[Any]

    def take(self) -> tuple[bytes, int] | None:
        """Return the next message, serialised, and when it arrived (ns); None: there is none."""
        subscription = self.subscription
        with subscription.handle:
            taken = subscription.handle.take_message(subscription.msg_type, True)
        return None if taken is None else (taken[0], int(taken[1]['received_timestamp']))
