"""
The nodes' executables: they answer ``--help`` and Ctrl-C while a node's imports would take long.

A node imports much, and prepares compiled loops, the first time for a minute.
"""

from __future__ import annotations

import os
import signal
import sys
from functools import partial
from importlib import import_module

from mctrack_ros.ros.node.usage import asked_for_help, usage


def start(node: str) -> int:
    """Run a node of the package by its name; return the exit code."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os._exit(0))
    if asked_for_help(sys.argv[1:]):
        print(usage(node))
        return 0
    code: int = import_module(f'mctrack_ros.ros.nodes.{node}').main()
    return code


camera_node = partial(start, 'camera_node')
fusion_node = partial(start, 'fusion_node')
coverage_node = partial(start, 'coverage_node')
stream_node = partial(start, 'stream_node')
store_node = partial(start, 'store_node')
video_node = partial(start, 'video_node')
simulator_node = partial(start, 'simulator_node')
recorder = partial(start, 'recorder')
player = partial(start, 'player')
