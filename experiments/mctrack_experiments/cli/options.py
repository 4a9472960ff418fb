"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path

import typer

RUNS: Path = typer.Option(Path('docs/runs.json'), help='File that keeps the runs on fresh seeds.')
