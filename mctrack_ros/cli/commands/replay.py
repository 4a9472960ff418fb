"""`mctrack replay`: the same bag gives the same answer."""

from __future__ import annotations

import time
from pathlib import Path

import typer

from mctrack_ros.site.names import namespace_of


def replay(
    bag: Path = typer.Argument(
        ..., help='A recorded bag with detections, or the folder of `mctrack track`.'
    ),
    verify: bool = typer.Option(
        False, '--verify', help='Fail unless the tracks are those that the bag holds.'
    ),
    site: str = typer.Option(
        '', help='Site YAML, or the name of a shipped site; unless given, what the bag says.'
    ),
    namespace: str = typer.Option(
        '', callback=namespace_of, help='Namespace of the topics in the bag, for example /hall.'
    ),
    until: float | None = typer.Option(
        None, min=0.0, help='Time since the first tick after which it ends, s.'
    ),
    save_state: Path | None = typer.Option(
        None, help="Also write the tracker's state after the last tick, to go on from."
    ),
    from_state: Path | None = typer.Option(
        None, help='Go on behind the tick at which such a file was written.'
    ),
) -> None:
    """Fuse the detections of a bag again in lock step, and compare the tracks, bit by bit."""
    from mctrack_ros.cli.sites import named_site
    from mctrack_ros.replay.proof.verify import Replay, verify_bag

    how = Replay(
        named_site(site) if site else None,
        namespace,
        from_state.read_bytes() if from_state else None,
        until,
    )
    began_s = time.perf_counter()
    verdict, state = verify_bag(bag, how)
    speed = verdict.seconds / (time.perf_counter() - began_s)
    if save_state is not None:
        save_state.write_bytes(state)
    typer.echo(f'{verdict.line()}; {speed:.1f} times real time')
    if verify and verdict.is_fault:
        raise typer.Exit(1)
