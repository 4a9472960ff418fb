"""`mctrack convert-calibration`, `mctrack check-calibration`."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from mctrack_ros.ground import CalibrationCheck

_LEAST_MISS_PX = 0.01
_BY_ENDING = {'.xml': 'grid', '.yaml': 'camera_info', '.yml': 'camera_info'}


def convert_calibration(
    source: str = typer.Argument(
        ...,
        help='Calibration file of any format; a bag; or the topic of a running '
        'sensor_msgs/CameraInfo, for example /north/camera_info.',
    ),
    target: Path = typer.Argument(..., help='File to write.'),
    to: str = typer.Option(
        '',
        help='Format to write: grid, camera_info, opencv, tsai, image_from_world, '
        'image_from_ground or ground_from_image. Unless given, by the ending of the file: grid '
        'for .xml, camera_info for .yaml.',
    ),
    size: str = typer.Option(
        '', help='Width and height of the images, px, as 1920x1080, if the file lacks them.'
    ),
    extrinsics: Path | None = typer.Option(
        None, help="File with the camera's pose, if the calibration has none; replaces TF."
    ),
    topic: str = typer.Option(
        '',
        help='Of the CameraInfo in a bag, if it has several; or which camera of a file with '
        'several: its key there, or its topic.',
    ),
    frame: str = typer.Option('map', help='The ground frame in TF, for a topic or a bag.'),
    timeout: float = typer.Option(5.0, min=0.0, help='How long to wait for a topic, s.'),
    unit: str = typer.Option('m', help='Unit of lengths in the source: m, cm or mm.'),
    name: str = typer.Option(
        '', help='Name of the camera; by default that of the file or the topic.'
    ),
) -> None:
    """Convert a calibration between formats; lengths are written in metres (Tsai: millimetres)."""
    from mctrack_ros.cli.commands.calibration_source import Heard, read_source
    from mctrack_ros.ground import knows_its_error, write_calibration

    kind = to or _BY_ENDING.get(target.suffix.lower(), '')
    if not kind:
        raise ValueError(f'{target}: its ending names no format: name one with --to')
    stated = _size(size) if size else None
    mapping, title, notes = read_source(
        source, stated, extrinsics or '', unit, Heard(topic, frame, timeout)
    )
    for each in notes:
        typer.echo(f'{source}: {each}')
    missed = write_calibration(mapping, target, kind, name or title)
    note = f'; up to {missed:.2g} px off' if missed >= _LEAST_MISS_PX else ''
    width, height = mapping.image_size
    typer.echo(f'{target}: {kind}, for images of {width} x {height} px{note}')
    if knows_its_error(mapping):
        typer.echo(
            'The file does not say how good the points of the grid were: the covariance of the '
            'calibration and where it is extrapolated are lost. Keep the grid.'
        )


def check_calibration(
    source: str = typer.Argument(..., help='Site YAML, name of a shipped site, or a grid XML.'),
    size: str = typer.Option(
        '', help='Width and height of the images, px, as 1920x1080, if a grid lacks them.'
    ),
    json_file: Path | None = typer.Option(None, '--json', help='Also write the checks here.'),
) -> None:
    """Check each camera's points: errors, leave-one-out errors, suspicious points, a verdict."""
    from rich.console import Console

    from mctrack_ros.cli.tables import check_table

    checks = dict(_checks(source, size))
    Console().print(check_table(checks))
    for camera, check in checks.items():
        for line in (*check.warnings(), *([check.refusal] if check.refusal else [])):
            typer.echo(f'{camera}: {line}')
    if json_file is not None:
        values = {camera: _values(check) for camera, check in checks.items()}
        json_file.write_text(json.dumps(values, indent=2, allow_nan=False) + '\n')
    if any(check.refusal for check in checks.values()):
        raise typer.Exit(1)


def _checks(source: str, size: str) -> Iterator[tuple[str, CalibrationCheck]]:
    from mctrack_ros.cli.sites import calibration_doubts, camera_site
    from mctrack_ros.ground import check_grid, read_grid

    if source.endswith('.xml'):
        grid = read_grid(source)
        image = _size(size) if size else grid.image_size
        if image is None:
            raise ValueError(f'{source} does not say how large the images are: name --size')
        yield grid.workstation, check_grid(grid, image)
        return
    site = camera_site(source)
    for line in calibration_doubts(site):
        typer.echo(line)
    for name, camera in site.cameras.items():
        if camera.grid:
            image = camera.image_width, camera.image_height
            yield name, check_grid(read_grid(camera.grid), image, camera.click_noise_px)
        else:
            camera.mapping()
            typer.echo(f'{name}: {camera.calibration} can be used; it has no points to check')


def _values(check: CalibrationCheck) -> dict[str, Any]:
    """Return a check for JSON; what is not known is null."""
    points = zip(check.names, check.residual_px, check.left_out_px, check.score)
    return {
        'accepted': not check.refusal,
        'refusal': check.refusal,
        'rms_px': _known(check.rms_px),
        'left_out_rms_px': _known(check.left_out_rms_px),
        'deviation_m': _known(check.deviation_m),
        'suspicious': list(check.suspicious),
        'points': [
            {
                'name': name,
                'residual_px': _known(residual),
                'left_out_px': _known(left_out),
                'score': _known(score),
            }
            for name, residual, left_out, score in points
        ],
    }


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition('x')
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise ValueError(f'size is {text!r}, expected for example 1920x1080')
    return int(width), int(height)
