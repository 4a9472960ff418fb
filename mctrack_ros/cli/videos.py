"""`mctrack import-videos`: video files into a bag."""

from __future__ import annotations

from pathlib import Path

import typer

_LATEST_S = 1e6


def import_videos(
    out: Path = typer.Argument(..., help='The bag to write.'),
    videos: list[str] = typer.Argument(..., help='camera=file, for example north=north.mp4.'),
    later: list[str] = typer.Option(
        [], help='camera=seconds, for a video that began so long after the first.'
    ),
    rate: float = typer.Option(
        0.0, min=0.0, max=1000.0, help='Pictures a second; 0: what each file states.'
    ),
    overwrite: bool = typer.Option(False, '--overwrite', help='Replace an earlier bag.'),
) -> None:
    """Put the videos of several cameras into a bag, to be tracked offline by `mctrack track`."""
    from mctrack_ros.cli.progress import progress_bar
    from mctrack_ros.recording.videos import open_video, write_videos

    files = _by_camera(videos, 'north=north.mp4')
    delays = {name: _seconds(text) for name, text in _by_camera(later, 'south=1.5').items()}
    for name in delays.keys() - files.keys():
        raise ValueError(f'--later names {name}, expected one of {", ".join(files)}')
    opened = {name: open_video(file, rate, delays.get(name, 0.0)) for name, file in files.items()}
    with progress_bar('reading') as progress:
        counts = write_videos(opened, out, overwrite=overwrite, progress=progress)
    for name, video in opened.items():
        width, height = video.size
        typer.echo(
            f'{name}: {counts[name]} pictures of {width} x {height} px, {video.rate_hz:g} a second'
        )
    typer.echo(f'wrote {out}')


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not 0 <= seconds < _LATEST_S:
        raise ValueError(f'--later has {text!r}, expected seconds, 0 or more')
    return seconds


def _by_camera(texts: list[str], example: str) -> dict[str, str]:
    """Return what stands after the equals sign, by camera."""
    from mctrack_ros.camera_names import check_camera_name

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
