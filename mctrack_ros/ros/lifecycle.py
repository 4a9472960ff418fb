"""What all nodes of the graph share: parameters, lifecycle, start and end of the process."""

from __future__ import annotations

import gc
import os
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar

import cv2
import rclpy
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import (
    LifecycleNode,
    LifecyclePublisher,
    LifecycleState,
    TransitionCallbackReturn,
)
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

from mctrack_ros.resources import config_file
from mctrack_ros.ros import parameters
from mctrack_ros.ros.supervise import BAD_CONFIGURATION, PARENT_VARIABLE

FAILED = 1
"""Exit code of a process that may be started again."""

_WAKE_S = 0.2


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
        self.ended = False
        self._publishers_made: list[LifecyclePublisher] = []
        self._lasting: set[int] = set()
        parameters.declare(self, self.CONFIG)
        parameters.refuse_changes(self, self.CONFIG, lambda: self.config is not None)

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
        self.finished = True

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
        are most of what waiting costs. Only picture topics, made without this, warn of mismatch.

        """
        silent = SubscriptionEventCallbacks(use_default_callbacks=False)
        self.create_subscription(kind, topic, callback, quality, event_callbacks=silent)

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
        if self.config is not None:
            self._release()
        self.finished = self.ended = True
        return super().on_shutdown(state)

    def _done(self, step: Callable[[], None]) -> bool:
        """Take a step; keep in one line why it failed (rclpy would swallow the reason)."""
        try:
            step()
        except (ValueError, OSError, RuntimeError) as error:
            self.failure = _one_line(error)
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
        self.config = None


def run(make: Callable[[], GraphNode], arguments: Sequence[str] | None = None) -> int:
    """
    Run one node until it is done or the process is told to end.

    Parameters
    ----------
    make : callable
        Makes the node.
    arguments : sequence of str, optional
        The command line; by default that of the process.

    Returns
    -------
    int
        Exit code: 0, 1 after a failure, 2 if the configuration is wrong.

    """
    cv2.setNumThreads(1)
    _prepare_environment()
    endings: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda caught, _: endings.append(caught))
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        node = make()
    except (ValueError, RuntimeError) as error:
        print(f'{Path(sys.argv[0]).stem}: {_one_line(error)}', file=sys.stderr)
        return BAD_CONFIGURATION
    try:
        return _live(node, endings)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def _prepare_environment() -> None:
    """Set what ROS reads from the environment, unless it is set: where to log, how to resend."""
    if 'HOME' not in os.environ:
        os.environ.setdefault('ROS_LOG_DIR', tempfile.gettempdir())
    os.environ.setdefault('FASTRTPS_DEFAULT_PROFILES_FILE', str(config_file('fastdds.xml')))


def _live(node: GraphNode, endings: list[int]) -> int:
    """Bring a node up, let it work, bring it down."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    if node.get_parameter('autostart').value:
        node.trigger_configure()
        if node.failure:
            return BAD_CONFIGURATION
        node.trigger_activate()
    gc.collect()
    gc.freeze()
    while not (endings or node.finished or _is_orphan()):
        executor.spin_once(timeout_sec=_WAKE_S)
    reason = node.failure
    if not node.ended:
        node.trigger_shutdown()
    return FAILED if reason or node.failure else 0


def _is_orphan() -> bool:
    """Tell whether the supervisor that started this process is gone."""
    parent = os.environ.get(PARENT_VARIABLE)
    return parent is not None and os.getppid() != int(parent)


def _one_line(error: Exception) -> str:
    """Return an error's text without line breaks, the traces of rcl's C code cut off."""
    return ' '.join(str(error).split(', at /')[0].split())
