"""Start and end of a node's process."""

from __future__ import annotations

import gc
import os
import signal
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

import cv2
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from mctrack_ros.resources import config_file
from mctrack_ros.ros.graph.supervise import BAD_CONFIGURATION, PARENT_VARIABLE
from mctrack_ros.ros.node.lifecycle import GraphNode, one_line
from mctrack_ros.ros.node.usage import asked_for_help, usage

FAILED = 1
"""Exit code of a process that may be started again."""

_WAKE_S = 0.2


def run(make: Callable[[], GraphNode], arguments: Sequence[str] | None = None) -> int:
    """
    Run one node until it is done or the process is signalled to end; print usage for --help.

    Parameters
    ----------
    make : callable
        Makes the node: its class.
    arguments : sequence of str, optional
        The command line; by default that of the process.

    Returns
    -------
    int
        Exit code: 0 after help, 2 if the configuration is wrong. A node that has lived ends the
        process itself, with 0, or 1 after a failure.

    """
    program = Path(sys.argv[0]).stem
    if asked_for_help(sys.argv[1:] if arguments is None else arguments):
        print(usage(program))
        return 0
    cv2.setNumThreads(1)
    prepare_environment()
    endings: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda caught, _: endings.append(caught))
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        node = make()
    except (ValueError, RuntimeError) as error:
        print(f'{program}: {one_line(error)}', file=sys.stderr)
        rclpy.try_shutdown()
        return BAD_CONFIGURATION
    try:
        code = _live(node, endings)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    if code != BAD_CONFIGURATION:
        _leave(code)
    return code


def _leave(code: int) -> NoReturn:
    """End the process: all is closed, and destructors of the middleware have hung for seconds."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def prepare_environment() -> None:
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
        if node.failure:
            return FAILED
        node.get_logger().info('active')
    gc.collect()
    gc.freeze()
    try:
        while not (endings or node.finished or _is_orphan()):
            try:
                executor.spin_once(timeout_sec=_WAKE_S)
            except Exception as error:
                node.survive(error)
    finally:
        reason = node.failure
        if not node.ended:
            node.trigger_shutdown()
    return FAILED if reason or node.failure else 0


def _is_orphan() -> bool:
    """Tell whether the supervisor that started this process is gone."""
    parent = os.environ.get(PARENT_VARIABLE)
    return parent is not None and os.getppid() != int(parent)
