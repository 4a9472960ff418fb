"""The commands that this distribution adds to `mctrack`."""

from __future__ import annotations

import typer

from mctrack_experiments.cli import bench, reproduce, results


def add_commands(app: typer.Typer) -> None:
    """Add the commands to the command line."""
    app.command('reproduce')(reproduce.reproduce)
    app.add_typer(bench.app, name='bench', help='Time the parts of the system on one core.')
    app.command('results')(results.results)
