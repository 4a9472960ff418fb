"""`mctrack bench`: how fast the parts are, beside a peer in the same run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mctrack_experiments.bench.parts import Part

if TYPE_CHECKING:
    from mctrack_ros.evaluation.figures import Figures


app = typer.Typer(no_args_is_help=True)
_JSON = typer.Option(None, '--json', help='Also write the figures here.')


@app.command()
def ground(json_file: Path | None = _JSON) -> None:
    """Time the ground mappings: points a second."""
    from mctrack_experiments.bench.ground import bench_ground

    _tell(bench_ground(), json_file)


@app.command()
def watchdog(json_file: Path | None = _JSON) -> None:
    """Time the watch for cameras that have moved."""
    from mctrack_experiments.bench.camera_shift import bench_watchdog

    _tell(bench_watchdog(), json_file)


@app.command()
def camera(json_file: Path | None = _JSON) -> None:
    """Time a camera's trackers: images a second."""
    from mctrack_experiments.bench.camera import bench_camera

    _tell(bench_camera(), json_file)


@app.command()
def fusion(
    part: list[Part] = typer.Option([], help='Measure this alone; may be repeated.'),
    seeds: str = typer.Option(
        '11-34', help='Scenes whose accuracy is measured: 11-34 are held out, 1-3 for tuning.'
    ),
    quick: bool = typer.Option(False, '--quick', help='Time fewer ticks, no slow trackers.'),
    alone: bool = typer.Option(False, '--alone', help='Run no other trackers.'),
    folder: Path | None = typer.Option(
        None, help='The benchmark; unless given, MCTRACK_BENCH or ../shared/bench.'
    ),
    json_file: Path | None = _JSON,
) -> None:
    """Measure fusion on synthetic scenes: time, accuracy beside other trackers, bad input."""
    from mctrack_experiments.bench import fusion as fusion_bench
    from mctrack_ros.cli.progress import progress_bar

    peers = () if alone else fusion_bench.installed_peers()
    missing = [name for name in fusion_bench.PEERS if name not in peers and not alone]
    if missing:
        names = ', '.join(missing)
        typer.echo(f'measuring without {names}; to have them: {fusion_bench.INSTALL}', err=True)
    figures = fusion_bench.bench_fusion(
        fusion_bench.toolkit_folder(folder),
        peers,
        tuple(part or Part),
        numbers(seeds),
        quick,
        progress_bar,
    )
    _tell(figures, json_file)


def numbers(text: str) -> tuple[int, ...]:
    """
    Return the numbers that a text lists, as ``1-3`` or ``1,2,5-7``.

    Raises
    ------
    ValueError
        If it lists none or anything else.

    """
    listed: list[int] = []
    for item in text.split(','):
        found = re.fullmatch(r'(\d+)(?:-(\d+))?', item)
        if found is None or int(found[2] or found[1]) < int(found[1]):
            raise ValueError(f'{text!r} lists no numbers, expected for example 11-34 or 1,2,3')
        first, last = found.groups()
        listed += range(int(first), int(last or first) + 1)
    return tuple(listed)


def _tell(figures: Figures, json_file: Path | None) -> None:
    """Print figures and, if asked, write them."""
    typer.echo(figures.table())
    if json_file is not None:
        figures.write(json_file)
