"""`mctrack bag` and `mctrack replay`: describe recordings, mend them, prove them."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import typer

from mctrack_ros.site.names import namespace_of

app = typer.Typer(no_args_is_help=True)


@app.callback()
def _root() -> None:
    """Describe and mend recordings."""


@app.command('repair')
def repair(
    bag: Path = typer.Argument(..., help='The bag, or one of its files; it is not changed.'),
    out: Path = typer.Argument(..., help='The bag to write.'),
    overwrite: bool = typer.Option(False, '--overwrite', help='Replace an earlier bag.'),
) -> None:
    """Write a finished bag with all that can be read of a cut or damaged one."""
    from mctrack_ros.recording.bags.repair import repair_bag

    count, seconds = repair_bag(bag, out, overwrite=overwrite)
    typer.echo(f'wrote {out}: {count} messages, {seconds:.3f} s')


@app.command('info')
def info(
    bag: Path = typer.Argument(..., help='The bag, or one of its files.'),
    as_json: bool = typer.Option(False, '--json', help='As JSON.'),
) -> None:
    """Say what a bag holds: topics, rates, what was lost, what is attached, who made it."""
    said = _described(bag)
    if as_json:
        typer.echo(json.dumps(said, indent=1))
        return
    begin = datetime.fromtimestamp(said['begin_s'], UTC).isoformat(' ', 'milliseconds')
    typer.echo(
        f'{bag}: {said["messages"]} messages, {said["seconds"]:.3f} s from {begin}, '
        f'{said["bytes"] / 1e6:.1f} MB in {said["files"]} file(s)'
    )
    _show_topics(said['topics'])
    for name, size in said['attachments'].items():
        typer.echo(f'attached: {name}, {size} bytes')
    for topic, each in said['track_logs'].items():
        typer.echo(f'track log {topic}: {each["messages"]} messages, sha256 {each["sha256"]}')
    versions = [f'{name} {each}' for name, each in said['made_by'].items() if name != 'processor']
    if versions:
        typer.echo(f'made by {", ".join(versions)}')


def _show_topics(topics: Mapping[str, Any]) -> None:
    """Print what a bag holds of each topic."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table('topic', 'type', 'messages', 'per second', 'lost', box=box.SIMPLE_HEAD)
    for topic, each in topics.items():
        lost = '' if each['lost'] is None else str(each['lost'])
        table.add_row(topic, each['type'], str(each['messages']), f'{each["rate"]:.2f}', lost)
    Console(width=200).print(table)


def _described(bag: Path) -> dict[str, Any]:
    """Return what a bag holds, as plain values."""
    from mctrack_ros.recording import BagReader, attachments
    from mctrack_ros.recording.bags.files import STORAGES
    from mctrack_ros.recording.track_log.log import RECORDING, StoredLog

    attached = attachments(bag)
    stored, recorded = StoredLog.of(attached), json.loads(attached.get(RECORDING, b'{}'))
    files = [each for each in bag.iterdir() if each.suffix in STORAGES] if bag.is_dir() else [bag]
    with BagReader(bag) as reader:
        seconds = reader.duration_s
        topics = {
            topic: {
                'type': reader.topics[topic],
                'messages': reader.count(topic),
                'rate': reader.count(topic) / max(seconds, 1e-9),
                'lost': recorded.get(topic, {}).get('lost'),
            }
            for topic in sorted(reader.topics)
        }
        begin_s = reader.begin_ns * 1e-9
    return {
        'begin_s': begin_s,
        'seconds': seconds,
        'bytes': sum(file.stat().st_size for file in files),
        'files': len(files),
        'messages': sum(each['messages'] for each in topics.values()),
        'topics': topics,
        'attachments': {name: len(data) for name, data in sorted(attached.items())},
        'track_logs': {
            topic: {'messages': count, 'sha256': digest.hex()}
            for topic, (count, digest) in stored.hashes.items()
        },
        'made_by': dict(stored.made_by),
    }


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
    from mctrack_ros.cli.sites import optional_site
    from mctrack_ros.replay.proof.verify import Replay, verify_bag

    how = Replay(
        optional_site(site),
        namespace,
        from_state.read_bytes() if from_state else None,
        until,
    )
    began_s = time.perf_counter()
    check, state = verify_bag(bag, how)
    speed = check.seconds / (time.perf_counter() - began_s)
    if save_state is not None:
        save_state.write_bytes(state)
    typer.echo(f'{check.line()}; {speed:.1f} times real time')
    if verify and check.is_fault:
        raise typer.Exit(1)
