"""Video files: `mctrack import-videos`, and what `mctrack track` shares with it."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from mctrack_ros.recording.video.videos import Video

_LATEST_S = 1e6
LATER = typer.Option([], help='camera=seconds: this video began so much later than the others.')
RATE = typer.Option(
    0.0,
    min=0.0,
    max=1000.0,
    help='Images a second of the videos; 0: the times that each file states.',
)


def import_videos(
    out: Path = typer.Argument(..., help='The bag to write.'),
    videos: list[str] = typer.Argument(
        ..., help='camera=file, or folder of images, for example north=north.mp4.'
    ),
    later: list[str] = LATER,
    rate: float = RATE,
    overwrite: bool = typer.Option(False, '--overwrite', help='Replace an earlier bag.'),
) -> None:
    """Put the videos of several cameras into a bag, to be tracked offline by `mctrack track`."""
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.recording.video.videos import write_videos

    opened = open_videos(videos, later, rate)
    notes: list[str] = []
    try:
        with progress_bar('reading') as progress:
            counts = write_videos(
                opened, out, overwrite=overwrite, progress=progress, tell=notes.append
            )
    finally:
        for note in notes:
            warn(note)
    for name, count in counts.items():
        typer.echo(f'{name}: {count} images')
    typer.echo(f'wrote {out}')


def open_videos(files: list[str], later: list[str], rate: float) -> dict[str, Video]:
    """
    Look into the videos of several cameras and say what they are.

    Parameters
    ----------
    files, later : list of str
        ``camera=file`` and ``camera=seconds``.
    rate : float
        Images a second; 0: at the times that each file states.

    Raises
    ------
    ValueError
        If a text is not so, or a file no video.

    """
    from mctrack_ros.recording.video.videos import open_video, strangers

    paths = by_camera(files, 'north=north.mp4')
    delays = delays_of(later, paths)
    videos = {name: open_video(path, rate, delays.get(name, 0.0)) for name, path in paths.items()}
    for name, video in videos.items():
        width, height = video.size
        typer.echo(
            f'{name}: {width} x {height} px, {video.rate_hz:g} images a second, '
            f'{video.length_s:.2f} s from {video.begin_s:.3f} s on',
            err=True,
        )
    for line in strangers(videos):
        warn(line)
    return videos


def warn(line: str) -> None:
    """Write a note to standard error."""
    typer.echo(f'warning: {line}', err=True)


def delays_of(later: list[str], cameras: Collection[str]) -> dict[str, float]:
    """Return the delays of --later by camera, s."""
    stated = by_known_camera('--later', later, 'south=1.5', cameras)
    return {name: _seconds(text) for name, text in stated.items()}


def _seconds(text: str) -> float:
    """Return a delay of --later, s; raise `ValueError` if it is none."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not 0 <= seconds < _LATEST_S:
        raise ValueError(f'--later has {text!r}, expected seconds, 0 or more')
    return seconds


def by_known_camera(
    option: str, texts: list[str], example: str, cameras: Collection[str]
) -> dict[str, str]:
    """Return an option's values by camera; raise `ValueError` for unknown cameras."""
    found = by_camera(texts, example)
    for name in found.keys() - set(cameras):
        raise ValueError(f'{option} names {name}, expected one of {", ".join(cameras)}')
    return found


def by_camera(texts: list[str], example: str) -> dict[str, str]:
    """Return the values after the equals signs, by camera."""
    from mctrack_ros.site.names import check_camera_name

    found: dict[str, str] = {}
    for text in texts:
        name, _, value = text.partition('=')
        if not value:
            raise ValueError(f'{text!r}: expected a camera and its value, for example {example}')
        check_camera_name(name)
        if name in found:
            raise ValueError(f'{name} is given twice')
        found[name] = value
    return found
