"""What a supervisor says of its processes on `/diagnostics`."""

from __future__ import annotations

import time
from collections.abc import Sequence

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.duration import Duration
from rclpy.signals import SignalHandlerOptions

from mctrack_ros.codec import header
from mctrack_ros.ros.graph.supervise import ProcessState
from mctrack_ros.ros.health.stream_health import PERIOD_S, status
from mctrack_ros.ros.node.process import prepare_environment
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.ros.topics.quality import reliable

NODE = 'supervisor'
_HEARD_S = 3.0
"""Time that the last words wait for a listener, s: nodes take up to two to find one another."""
_POLL_S = 0.05
_RECENT_S = 5.0
"""Time for which a process that was started again is a warning."""


class ProcessHealth:
    """
    Publish how processes are: once a second, and at once when one ends or begins.

    Parameters
    ----------
    namespace : str
        Of the node that publishes.
    domain : int, optional
        ROS domain; unless given, that of the environment.

    """

    def __init__(self, namespace: str = '', domain: int | None = None) -> None:
        prepare_environment()
        self._context = rclpy.Context()
        rclpy.init(
            args=[],
            context=self._context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self._node = rclpy.create_node(
            NODE,
            namespace=namespace,
            context=self._context,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._publisher = self._node.create_publisher(
            DiagnosticArray, '/diagnostics', reliable(10)
        )
        self._last: list[tuple[str, bool, int]] = []
        self._sent_s = 0.0
        self._unheard: DiagnosticArray | None = None

    def look(self, states: Sequence[ProcessState]) -> None:
        """Publish if a second has passed, or a process is another than before."""
        now_s, last = time.monotonic(), [(s.name, s.is_running, s.starts) for s in states]
        if last == self._last and now_s - self._sent_s < PERIOD_S:
            return
        self._last, self._sent_s = last, now_s
        name = self._node.get_fully_qualified_name()
        message = DiagnosticArray(
            header=header(RCLPY_CLASSES, self._node.get_clock().now().nanoseconds, ''),
            status=[_status(f'{name}: {state.name}', state) for state in states],
        )
        is_bad = any(each.level != DiagnosticStatus.OK for each in message.status)
        self._unheard = (
            message if is_bad and not self._publisher.get_subscription_count() else None
        )
        self._publisher.publish(message)

    def close(self) -> None:
        """Say a fault that nobody has heard once more, as soon as somebody listens; then go."""
        until_s = time.monotonic() + _HEARD_S
        while self._unheard is not None and time.monotonic() < until_s:
            if self._publisher.get_subscription_count():
                self._publisher.publish(self._unheard)
                self._unheard = None
            time.sleep(_POLL_S)
        self._publisher.wait_for_all_acked(Duration(seconds=_HEARD_S))
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


def _status(name: str, state: ProcessState) -> DiagnosticStatus:
    level, message = DiagnosticStatus.OK, 'runs'
    if not state.is_running:
        level, message = DiagnosticStatus.ERROR, f'ended with {state.code}'
        if state.is_awaited:
            message += ': it is started again'
        elif state.code and state.code > 0 and state.said:
            message += f': {state.said}'
        elif state.code == 0:
            level, message = DiagnosticStatus.OK, 'has ended'
    elif state.starts > 1 and state.up_s < _RECENT_S:
        level = DiagnosticStatus.WARN
        message = f'ended with {state.code}, was started again {state.up_s:.1f} s ago'
    values = {
        'starts': state.starts,
        'running [s]': f'{state.up_s:.1f}',
        'last exit code': '' if state.code is None else state.code,
    }
    found = status(name, level, message, values)
    found.hardware_id = state.name
    return found
