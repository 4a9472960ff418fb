"""`mctrack store`: bags and the trajectory database."""

from __future__ import annotations

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


def store_results(bag: Path, database: str | Path, site: str, *, overwrite: bool) -> None:
    """Write what was tracked into a database; an earlier run of that name may be replaced."""
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.store import Database, forget_run, run_of_bag, store_bag
    from mctrack_ros.store.runs import run_number

    run = run_of_bag(bag, site=site)
    with Database(database, create=True) as opened, progress_bar('storing') as progress:
        with opened.alone() as connection:
            number = run_number(connection, run.name) if overwrite else None
            if number is not None:
                forget_run(connection, number)
        store_bag(bag, opened, run=run, progress=progress)
    typer.echo(f'stored run {run.name} in {opened.name}')


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
