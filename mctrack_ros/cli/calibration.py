"""`mctrack convert-calibration`, `mctrack check-calibration`."""

from __future__ import annotations

from pathlib import Path

import typer

_BY_ENDING = {'.xml': 'grid', '.yaml': 'camera_info', '.yml': 'camera_info'}


def convert_calibration(
    source: Path = typer.Argument(..., help='Calibration file of any format.'),
    target: Path = typer.Argument(..., help='File to write.'),
    to: str = typer.Option(
        '',
        help='Format to write: grid, camera_info, opencv, tsai, image_from_world, '
        'image_from_ground or ground_from_image. Unless given, by the ending of the file: grid '
        'for .xml, camera_info for .yaml.',
    ),
    size: str = typer.Option(
        '', help='Width and height of the pictures, px, as 1920x1080, if the file lacks them.'
    ),
    extrinsics: Path | None = typer.Option(
        None, help="File with the camera's pose, if it is another."
    ),
    unit: str = typer.Option('m', help='Of lengths in the source: m, cm or mm.'),
    name: str = typer.Option('', help='Of the camera; unless given, that of the source file.'),
) -> None:
    """Convert a calibration between formats; lengths are written in metres (Tsai: millimetres)."""
    from mctrack_ros.ground import read_calibration, stated_size, write_calibration

    kind = to or _BY_ENDING.get(target.suffix.lower(), '')
    if not kind:
        raise ValueError(f'{target}: its ending names no format: name one with --to')
    picture = _size(size) if size else stated_size(source)
    if picture is None:
        raise ValueError(f'{source} does not say how large the pictures are: name it with --size')
    mapping = read_calibration(source, picture, extrinsics or '', unit)
    missed = write_calibration(mapping, target, kind, name or source.stem)
    note = f'; its lens is up to {missed:.2g} px off' if missed else ''
    typer.echo(f'{target}: {kind}, for pictures of {picture[0]} x {picture[1]} px{note}')


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition('x')
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise ValueError(f'size is {text!r}, expected for example 1920x1080')
    return int(width), int(height)
