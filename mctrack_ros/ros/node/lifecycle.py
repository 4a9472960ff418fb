"""What all nodes of the graph share: parameters and lifecycle."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.lifecycle import (
    LifecycleNode,
    LifecyclePublisher,
    LifecycleState,
    TransitionCallbackReturn,
)
from rclpy.qos import QoSProfile

from mctrack_ros.config import Parameter
from mctrack_ros.ros.node import parameters

AUTOSTART = 'configure and activate on start; false: wait for the lifecycle services'
"""What the parameter of this name does, which every node has."""


class GraphNode(LifecycleNode):
    """
    A lifecycle node whose parameters are the fields of a configuration dataclass.

    A subclass states its ``CONFIG`` and fills `open` (build the core and the publishers),
    `start` (subscriptions and timers), `stop` and `close`. Everything made between is destroyed
    by the base.

    Parameters
    ----------
    name : str
        Name of the node, unless it is remapped.

    """

    CONFIG: ClassVar[type[Any]]

    def __init__(self, name: str) -> None:
        super().__init__(name, automatically_declare_parameters_from_overrides=True)
        self.config: Any = None
        self.failure = ''
        self.finished = False
        self.exceptions = Exceptions()
        self.last_words: Callable[[], None] | None = None
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.ended = False
        self._publishers_made: list[LifecyclePublisher] = []
        self._lasting: set[int] = set()
        try:
            parameters.declare(self, self.CONFIG)
        except ValueError:
            self.destroy_node()
            raise
        parameters.refuse_changes(
            self,
            self.CONFIG,
            lambda one: self.config is not None and not self.may_change(one),
        )
        self.add_post_set_parameters_callback(self._follow)

    def set_parameters_atomically(self, parameter_list: list[Any]) -> SetParametersResult:
        """Set parameters, as a service asks; those that are so already may be read-only."""
        if parameters.already_are(self, parameter_list):
            return SetParametersResult(successful=True)
        return super().set_parameters_atomically(parameter_list)

    def _follow(self, changes: list[Any]) -> None:
        if self.config is not None:
            before, self.config = self.config, parameters.read(self, self.CONFIG)
            self.changed({change.name for change in changes}, before)

    def may_change(self, parameter: Parameter) -> bool:
        """Tell whether a parameter may change while the node is configured."""
        return parameter.at_run_time

    def changed(self, names: set[str], before: Any) -> None:
        """Follow parameters that have changed; before that, the configuration was another."""

    def open(self) -> None:
        """Build the core and the publishers from ``self.config``."""

    def start(self) -> None:
        """Create what receives: subscriptions and timers."""

    def stop(self) -> None:
        """Finish what `start` began."""

    def close(self) -> None:
        """Release what `open` took."""

    def finish(self) -> None:
        """End the process after the current callback."""
        self.finished = True

    def fail(self, reason: str) -> None:
        """End the process with a reason and a failure's exit code."""
        self.failure = reason
        self.get_logger().error(reason)
        if self.last_words is not None:
            self.last_words()
        self.finished = True

    def survive(self, error: Exception) -> None:
        """Go on after an exception that a callback let out: it is counted and logged."""
        line = self.exceptions.note(error)
        trace = ''.join(traceback.format_exception(error))
        self.get_logger().error(f'{line}: the node goes on', throttle_duration_sec=5.0)
        self.get_logger().debug(trace)

    def publisher(self, kind: type[Any], topic: str, quality: QoSProfile) -> LifecyclePublisher:
        """Create a publisher that lives from `open` to `close`."""
        silent = PublisherEventCallbacks(use_default_callbacks=False)
        made = self.create_lifecycle_publisher(kind, topic, quality, event_callbacks=silent)
        self._publishers_made.append(made)
        return made

    def subscribe(
        self, kind: type[Any], topic: str, callback: Callable[..., None], quality: QoSProfile
    ) -> None:
        """
        Create a subscription that lives from `start` to `stop`.

        It has no handlers of QoS events: each would be waited on with every message, and they
        are most of what waiting costs. Only image topics, made without this, warn of mismatch.

        """
        silent = SubscriptionEventCallbacks(use_default_callbacks=False)
        self.create_subscription(kind, topic, callback, quality, event_callbacks=silent)

    def every(self, period_s: float, callback: Callable[[], None]) -> None:
        """Call back again and again in real time, though time may be simulated or stand still."""
        self.create_timer(period_s, callback, clock=self._steady)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the parameters and build; a failure leaves the node unconfigured."""
        self.failure = ''
        self.config = parameters.read(self, self.CONFIG)
        if not self._done(self.open):
            self._release()
            return TransitionCallbackReturn.FAILURE
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start to receive; a failure leaves the node inactive."""
        super().on_activate(state)
        self._lasting = {id(item) for item in (*self.subscriptions, *self.timers)}
        if self._done(self.start):
            return TransitionCallbackReturn.SUCCESS
        self._halt()
        super().on_deactivate(state)
        return TransitionCallbackReturn.FAILURE

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop to receive."""
        self._halt()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Go back to how the node was made."""
        self._release()
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop from whatever state, and end the process."""
        if state.label == 'active':
            self._halt()
        self.finished = self.ended = True
        if self.config is not None:
            self._release()
        return super().on_shutdown(state)

    def _done(self, step: Callable[[], None]) -> bool:
        """Take a step; keep in one line why it failed (rclpy would swallow the reason)."""
        try:
            step()
        except (ValueError, OSError, RuntimeError) as error:
            self.failure = one_line(error)
        except Exception:
            self.failure = traceback.format_exc()
        else:
            return True
        self.get_logger().error(self.failure)
        return False

    def _halt(self) -> None:
        """Stop, and destroy what `start` created."""
        self._done(self.stop)
        for subscription in [s for s in self.subscriptions if id(s) not in self._lasting]:
            self.destroy_subscription(subscription)
        for timer in [t for t in self.timers if id(t) not in self._lasting]:
            self.destroy_timer(timer)

    def _release(self) -> None:
        """Close, and destroy what `open` created."""
        self._done(self.close)
        for publisher in self._publishers_made:
            self.destroy_lifecycle_publisher(publisher)
        self._publishers_made.clear()
        self.config = self.last_words = None


def one_line(error: Exception) -> str:
    """Return an error's text without line breaks, the traces of rcl's C code cut off."""
    return ' '.join(str(error).split(', at /')[0].split())


@dataclass(slots=True)
class Exceptions:
    """
    What callbacks of a node have raised.

    Attributes
    ----------
    count, reported : int
        Exceptions since the start, and at the last report.
    last : str
        What the last one says, and where it was raised.

    """

    count: int = 0
    reported: int = 0
    last: str = ''

    def note(self, error: Exception) -> str:
        """Count an exception and return it in one line."""
        self.count += 1
        place = traceback.extract_tb(error.__traceback__)[-1]
        text = ' '.join(str(error).split())
        self.last = f'{type(error).__name__}: {text} ({place.filename}:{place.lineno})'
        return self.last

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: an error if anything was raised since the last report."""
        level, message = DiagnosticStatus.OK, 'no exception'
        if self.count:
            level, message = DiagnosticStatus.WARN, f'{self.count} so far; the last: {self.last}'
        if self.count > self.reported:
            level = DiagnosticStatus.ERROR
        self.reported = self.count
        return DiagnosticStatus(
            level=level,
            name=name,
            message=message,
            values=[KeyValue(key='exceptions', value=str(self.count))],
        )
