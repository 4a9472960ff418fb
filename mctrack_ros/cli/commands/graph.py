"""Commands that start ROS processes: run, record, play."""

from __future__ import annotations

import signal
import sys
import tempfile
import threading
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mctrack_ros.site.names import namespace_of

if TYPE_CHECKING:
    from mctrack_ros.ros.graph.graph import NodeSpec
    from mctrack_ros.ros.graph.supervise import Supervisor

_DOMAIN = typer.Option(
    None, min=0, max=232, help='ROS domain; unless given, that of ROS_DOMAIN_ID.'
)


def run(
    site: str = typer.Argument(..., help='Site YAML, or the name of a shipped site.'),
    namespace: str = typer.Option(
        '', callback=namespace_of, help='Namespace of all nodes, for example hall.'
    ),
    use_sim_time: bool = typer.Option(False, '--use-sim-time', help='Use the time of /clock.'),
    own_detections: bool = typer.Option(
        False,
        '--own-detections',
        help='Start no camera nodes: your own detectors send <camera>/detections.',
    ),
    stream: int | None = typer.Option(
        None,
        min=0,
        max=65535,
        help='Also give tracks and events to other programs of this machine on this port, over '
        'HTTP and web sockets.',
    ),
    store: str = typer.Option(
        '',
        help='Trajectory database in which tracks and events are kept: a file, made unless it is '
        'there, or a URL such as postgresql://user@host/name.',
    ),
    domain: int | None = _DOMAIN,
) -> None:
    """Run the graph of a site: a node a camera, fusion and coverage; of cells, fusion alone."""
    from mctrack_ros.cli.sites import named_site, site_path
    from mctrack_ros.ros.graph.graph import coverage_node, stream_node
    from mctrack_ros.ros.graph.site_graph import site_nodes, store_node
    from mctrack_ros.site.choice import with_tracker

    config, why = with_tracker(named_site(site), own_detections)
    if why:
        typer.echo(why, err=True)
    nodes = site_nodes(config, use_sim_time, own_detections)
    if config.cameras:
        nodes.append(coverage_node(site_path(site), use_sim_time))
    if stream is not None:
        nodes.append(stream_node(stream, use_sim_time, geo=config.geo))
    if store:
        nodes.append(store_node(store, config, use_sim_time))
    _run_nodes(nodes, namespace, domain)


def record(
    out: Path = typer.Argument(..., help='The bag to write.'),
    topics: list[str] = typer.Option(
        ['.*'], '--topic', help='Regular expression of topics to record; may be repeated.'
    ),
    namespace: str = typer.Option(
        '',
        callback=namespace_of,
        help='Only topics in this namespace; --topic then matches the rest of the name.',
    ),
    exclude: str | None = typer.Option(
        None, help='Regular expression of topics that are not recorded.'
    ),
    types: list[str] = typer.Option(
        ['.*'], '--type', help='Regular expression of message types; may be repeated.'
    ),
    site: str = typer.Option('', help='Site that the bag carries, with its calibrations.'),
    sqlite: bool = typer.Option(False, '--sqlite', help='Record into SQLite, not MCAP.'),
    split_mb: float = typer.Option(0.0, min=0.0, help='Size from which a file is followed, MB.'),
    split_s: float = typer.Option(0.0, min=0.0, help='Time after which a file is followed, s.'),
    min_free_mb: float = typer.Option(
        500.0, min=0.0, help='Free disk space with which recording stops, MB.'
    ),
    overwrite: bool = typer.Option(False, '--overwrite', help='Replace an earlier bag.'),
    explain: bool = typer.Option(
        False, '--explain', help='Also record the explanations of fusion.'
    ),
    private: bool = typer.Option(
        False, '--private', help='Record no pictures; nor are they if a private site runs.'
    ),
    domain: int | None = _DOMAIN,
) -> None:
    """Record topics of the running graph into a bag until Ctrl-C; lost messages are a failure."""
    from mctrack_ros.cli.sites import site_path
    from mctrack_ros.ros.graph.graph import recorder_node

    if namespace:
        topics = [f'{namespace}(?=/)(?:{pattern})' for pattern in topics]
    parameters = {
        'types': types,
        'site': str(site_path(site).absolute()) if site else '',
        'storage': 'sqlite3' if sqlite else 'mcap',
        'split_mb': split_mb,
        'split_s': split_s,
        'min_free_mb': min_free_mb,
        'overwrite': overwrite,
        'explain': explain,
        'private': private,
    }
    if exclude is not None:
        parameters['exclude'] = exclude
    node = recorder_node(out.absolute(), topics, **parameters)
    _run_nodes([node], '', domain)


def play(
    bag: Path = typer.Argument(..., help='The bag.'),
    topics: list[str] = typer.Option(
        ['.*'], '--topic', help='Regular expression of topics to play; may be repeated.'
    ),
    namespace: str = typer.Option(
        '',
        callback=namespace_of,
        help='Namespace to play into; topics already in it keep their names.',
    ),
    rate: float = typer.Option(1.0, min=0.001, max=1000.0, help='Speed; 1: as recorded.'),
    start: float = typer.Option(0.0, min=0.0, help='Where in the bag to begin, s.'),
    duration: float = typer.Option(0.0, min=0.0, help='Length to play, s; 0: all.'),
    loop: bool = typer.Option(False, '--loop', help='Begin again at the end.'),
    paused: bool = typer.Option(False, '--paused', help='Begin paused.'),
    exclude: str = typer.Option('', help='Regular expression of topics that are not played.'),
    remap: list[str] = typer.Option(
        [], help='Play a topic under another name, /from:=/to; may be repeated.'
    ),
    restamp: bool = typer.Option(
        False, '--restamp', help='Shift all stamps as if captured now, and publish no /clock.'
    ),
    domain: int | None = _DOMAIN,
) -> None:
    """
    Play a bag into the running graph, with /clock.

    Keys: blank pauses, n plays the next message, + and - change the speed.
    """
    from mctrack_ros.recording import BagReader, CutBagWarning
    from mctrack_ros.ros.graph.graph import player_node

    with warnings.catch_warnings():
        warnings.simplefilter('ignore', CutBagWarning)  # the player says it
        BagReader(bag).close()
    node = player_node(
        bag.absolute(),
        topics=list(topics),
        exclude=exclude,
        remap=remap or [''],
        rate=rate,
        start=start,
        duration=duration,
        loop=loop,
        paused=paused,
        restamp=restamp,
    )
    _run_nodes([node], namespace, domain)


def _run_nodes(nodes: Sequence[NodeSpec], namespace: str, domain: int | None) -> None:
    """Run nodes as processes until they end or a signal comes; exit with their code."""
    from mctrack_ros.ros.graph.graph import ENVIRONMENT
    from mctrack_ros.ros.graph.process_health import ProcessHealth
    from mctrack_ros.ros.graph.supervise import Supervisor

    environment = dict(ENVIRONMENT)
    if domain is not None:
        environment['ROS_DOMAIN_ID'] = str(domain)
    with tempfile.TemporaryDirectory(prefix='mctrack_') as directory:
        processes = [node.process(Path(directory), namespace) for node in nodes]
        health = ProcessHealth(namespace, domain)
        supervisor = Supervisor(processes, typer.echo, environment, health.look)
        if any(node.takes_keys for node in nodes) and sys.stdin.isatty():
            threading.Thread(target=_forward_keys, args=(supervisor,), daemon=True).start()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda *_: supervisor.stop())
        code = supervisor.run()
        health.close()
    raise typer.Exit(code)


def _forward_keys(supervisor: Supervisor) -> None:
    """Hand each key of the terminal to the nodes that take some."""
    while key := typer.getchar():
        supervisor.press(key)
