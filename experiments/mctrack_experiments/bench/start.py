"""How long a first start takes, when inner loops are compiled, and a later one."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time

from mctrack_ros.evaluation.figures import Figures

PREPARE = '-c', 'from mctrack_ros.cli.live import prepare_nodes; prepare_nodes()'
HELP = '-m', 'mctrack_ros.ros.nodes.camera_node', '--help'


def bench_start() -> Figures:
    """
    Measure starts of processes, s.

    The ``first`` finds no compiled loops, and compiles those of the default trackers on all cores;
    a ``later`` one reads them. ``help`` is that of `camera_node` before, which compiles nothing.
    """
    with tempfile.TemporaryDirectory() as cache:
        figures = {
            'help.s': _seconds(cache, *HELP),
            'first.s': _seconds(cache, *PREPARE),
            'later.s': _seconds(cache, *PREPARE),
            'cores': float(os.cpu_count() or 1),
        }
    protocol = {'first, later': 'until the default trackers can run, Python imports counted'}
    return Figures('bench_start', 'mctrack bench start', protocol, figures)


def _seconds(cache: str, *command: str) -> float:
    """Run a command of Python with a cache of its own; return how long that took, s."""
    environment = os.environ | {'NUMBA_CACHE_DIR': cache, 'PYTHONPATH': os.pathsep.join(sys.path)}
    began = time.perf_counter()
    subprocess.run([sys.executable, *command], env=environment, check=True, capture_output=True)
    return time.perf_counter() - began
