"""`mctrack stream`: a recorded run as a stream's files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from mctrack_ros.streams.frames import About, Frame


def stream(
    source: str = typer.Argument(
        ..., help='Database (a file, or a URL), or bag, or what `mctrack track` wrote.'
    ),
    xml: Path | None = typer.Option(None, help='Trajectory XML to write.'),
    json: Path | None = typer.Option(None, help='JSON to write, a line a tick.'),
    onvif: Path | None = typer.Option(None, help='ONVIF metadata to write.'),
    run: str = typer.Option('', help='Name of the run, if the database has several.'),
    geo: str = typer.Option(
        '',
        help='For ONVIF: latitude,longitude of the origin of positions and, third, where the y '
        'axis points to, clockwise from north, degrees.',
    ),
) -> None:
    """Write a run as stream_node sends it: what was said at the time, before corrections."""
    from mctrack_ros.streams.formats.geo import GeoReference
    from mctrack_ros.streams.formats.profiles import all_profiles

    named = dict(zip(('tracks.xml', 'tracks.json', 'onvif.xml'), (xml, json, onvif)))
    wanted = [
        (profile, path)
        for profile in all_profiles(GeoReference.read(geo))
        if (path := named[profile.name]) is not None
    ]
    if not wanted:
        raise typer.BadParameter('say what to write: --xml, --json or --onvif')
    count = 0
    with ExitStack() as stack:
        about, frames = _opened(source, run, stack)
        files = [stack.enter_context(path.open('w', encoding='utf-8')) for _, path in wanted]
        for (profile, _), file in zip(wanted, files):
            file.write(profile.head(about))
        for frame in frames:
            count += 1
            for (profile, _), file in zip(wanted, files):
                file.write(profile.frame(frame))
        for (profile, _), file in zip(wanted, files):
            file.write(profile.tail)
    typer.echo(f'wrote {", ".join(str(path) for _, path in wanted)}: {count} ticks')


def _opened(source: str, run: str, stack: ExitStack) -> tuple[About, Iterator[Frame]]:
    from mctrack_ros.store import Database
    from mctrack_ros.store.exchange import bag_of
    from mctrack_ros.streams.sources import RunFrames, about_bag, about_run, bag_frames

    bag = bag_of(source)
    if bag is not None:
        about = about_bag(bag)
        return about, bag_frames(bag, about)
    database = stack.enter_context(Database(source))
    about = about_run(database, run)
    return about, iter(RunFrames(database, about))
