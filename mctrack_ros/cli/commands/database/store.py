"""`mctrack store`: bags and the trajectory database."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import typer

from mctrack_ros.cli.options import finite


def store(
    bag: Path = typer.Argument(..., help='Bag with tracks, of `mctrack track` or `record`.'),
    database: str = typer.Argument(
        ...,
        help='Database: a file of SQLite, made unless it is there, or a URL such as '
        'postgresql://user@host/name.',
    ),
    run: str = typer.Option('', help='What the run is called; by default as /site says.'),
    site: str = typer.Option('site', help='Name of the site.'),
    video: list[str] = typer.Option(
        [], '--video', help='Video of a camera, linked, not copied: camera=file.'
    ),
    began: float = typer.Option(
        0.0,
        '--videos-from',
        callback=finite,
        help="When the videos begin, since the run's first tick, s; may be negative.",
    ),
) -> None:
    """Write the tracks, events and corrections of a bag into a trajectory database."""
    from mctrack_ros.cli.commands.videos import by_known_camera
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.store import Database, Run, VideoFile, link_videos, run_of_bag, store_bag

    new = run_of_bag(bag, run, site)
    files = by_known_camera('--video', video, 'north=north.mp4', new.cameras)
    lengths = {camera: _length_s(file) for camera, file in files.items()}
    with Database(database, create=True) as opened, progress_bar('messages') as progress:
        store_bag(bag, opened, run=new, progress=progress)
        if files:
            stored = Run(opened, new.name)
            first_ns = stored.ns(began)
            link_videos(
                stored,
                [
                    VideoFile(camera, file, first_ns, first_ns + round(lengths[camera] * 1e9))
                    for camera, file in files.items()
                ],
            )
    typer.echo(f'stored run {new.name} in {opened.name}')


def check_database(database: str, run: str, *, overwrite: bool) -> None:
    """Say before the work what is wrong with a database, and that it has a run already."""
    from mctrack_ros.store import Database, StoreError
    from mctrack_ros.store.runs import run_number

    with Database(database, create=True) as opened, opened.connected() as connection:
        if run and not overwrite and run_number(connection, run) is not None:
            raise StoreError(
                f'run {run} is in {opened.name} already: give another --run, or --overwrite'
            )


def store_results(
    folder: Path, database: str | Path, site: str, run: str = '', *, overwrite: bool
) -> None:
    """
    Write what was tracked into a database.

    Parameters
    ----------
    folder : Path
        With the results, in ``bag``.
    database, site : str or Path, str
        Where they go, and the name of the site.
    run : str
        What the run is called; unless given, as the folder, with a number if that is taken.
    overwrite : bool
        Whether a run of that name is replaced; without a name, one of the same results alone.

    """
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.store import Database, forget_run, run_of_bag, store_bag
    from mctrack_ros.store.runs import free_name, run_number, runs_that_say

    said = run_of_bag(folder / 'bag', site=site)
    with Database(database, create=True) as opened, progress_bar('storing') as progress:
        with opened.alone() as connection:
            name = run or folder.resolve().name
            if run:
                number = run_number(connection, run)
                before = [] if number is None else [number]
            else:
                before = runs_that_say(connection, said.name, name)
            for number in before if overwrite else ():
                forget_run(connection, number)
            name = run or free_name(connection, name)
        store_bag(folder / 'bag', opened, run=replace(said, name=name), progress=progress)
    typer.echo(f'stored run {name} in {opened.name}')


def export_bag(
    database: str = typer.Argument(..., help='Database: a file, or a URL.'),
    bag: Path = typer.Argument(..., help='The bag to write.'),
    run: str = typer.Option('', help='Name of the run, if there are several.'),
    overwrite: bool = typer.Option(False, '--overwrite', help='Replace an earlier bag.'),
) -> None:
    """Write a run of a trajectory database as a bag."""
    from mctrack_ros.store import Database, write_bag

    with Database(database) as opened:
        count = write_bag(opened, bag, run=run, overwrite=overwrite)
    typer.echo(f'wrote {bag}: {count} messages')


def _length_s(file: str) -> float:
    """Return how long a video is, s."""
    from mctrack_ros.recording.video.videos import open_video

    return open_video(file).length_s
