"""Run the nodes of a measurement until they end; their output goes into a file."""

from __future__ import annotations

import multiprocessing
import os
import signal
import tempfile
from collections.abc import Sequence
from pathlib import Path

from mctrack_ros.compiled import prepare
from mctrack_ros.ros.graph.graph import ENVIRONMENT, NodeSpec
from mctrack_ros.ros.graph.supervise import Supervisor

MOST_PROCESSES = 4
"""Number of processes that compile: with more, each waits for what another one compiles."""


def run_to_end(nodes: Sequence[NodeSpec], log: Path, domain: int | None) -> None:
    """
    Run nodes as processes until the one that ends the graph does.

    Inner loops are compiled first: a player does not wait for nodes that take minutes to start.

    Parameters
    ----------
    nodes : sequence of NodeSpec
        What to run.
    log : Path
        File for what they say.
    domain : int or None
        ROS domain; None: that of the environment.

    Raises
    ------
    OSError
        If a process failed; says which, and names the file.

    """
    prepare_nodes()
    environment = dict(ENVIRONMENT)
    if domain is not None:
        environment['ROS_DOMAIN_ID'] = str(domain)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with (
        tempfile.TemporaryDirectory(prefix='mctrack_') as folder,
        log.open('w', encoding='utf-8') as lines,
    ):
        processes = [node.process(Path(folder)) for node in nodes]
        supervisor = Supervisor(processes, lambda line: print(line, file=lines), environment)
        supervisor.run()
    if supervisor.failures:
        raise OSError(f'{"; ".join(supervisor.failures)}: see {log}')


def prepare_nodes() -> None:
    """Compile the inner loops of the default trackers, on all cores, or find them compiled."""
    context = multiprocessing.get_context('spawn')
    others = min(os.cpu_count() or 1, MOST_PROCESSES) - 1
    helpers = [context.Process(target=_help_to_prepare, daemon=True) for _ in range(others)]
    for helper in helpers:
        helper.start()
    _prepare()
    for helper in helpers:
        helper.join()


def _prepare() -> None:
    import mctrack_ros.perception.trackers  # noqa: F401
    from mctrack_ros.fusion.trackers import COMPILED_ON_DEMAND

    prepare('mctrack_ros', *COMPILED_ON_DEMAND)


def _help_to_prepare() -> None:
    """Do the same; an interruption ends the process that waits for this one, and so this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _prepare()
