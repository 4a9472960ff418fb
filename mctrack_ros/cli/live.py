"""Run the nodes of a measurement until they end; their output goes into a file."""

from __future__ import annotations

import signal
import tempfile
from collections.abc import Sequence
from pathlib import Path

from mctrack_ros.compiled import prepare
from mctrack_ros.ros.graph.graph import ENVIRONMENT, NodeSpec
from mctrack_ros.ros.graph.supervise import Supervisor


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
    """Compile the inner loops that nodes call, or find them compiled."""
    import mctrack_ros.fusion.trackers
    import mctrack_ros.perception.trackers  # noqa: F401

    prepare('mctrack_ros')
