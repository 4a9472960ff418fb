"""`mctrack bench`: how fast the parts are, beside a peer in the same run."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path

import typer

from mctrack_ros.experiments.figures import Figures


class Part(StrEnum):
    """What can be timed."""

    GROUND = 'ground'
    WATCHDOG = 'watchdog'
    CAMERA = 'camera'


def bench(
    part: Part = typer.Argument(..., help='Which part.'),
    json_file: Path | None = typer.Option(None, '--json', help='Also write the figures here.'),
) -> None:
    """Time a part of the system on one core, beside a peer in the same run."""
    from mctrack_ros.experiments.bench_camera import bench_camera
    from mctrack_ros.experiments.bench_ground import bench_ground
    from mctrack_ros.experiments.bench_watchdog import bench_watchdog

    benches: dict[Part, Callable[[], Figures]] = {
        Part.GROUND: bench_ground,
        Part.WATCHDOG: bench_watchdog,
        Part.CAMERA: bench_camera,
    }
    figures = benches[part]()
    typer.echo(figures.table())
    if json_file is not None:
        figures.write(json_file)
