"""Checks of options before the work begins."""

from __future__ import annotations

import math
from pathlib import Path

import typer

IMAGES = ('.png', '.svg', '.pdf')


def finite(value: float) -> float:
    """Refuse NaN and infinity."""
    if not math.isfinite(value):
        raise typer.BadParameter(f'{value} is no time, expected a number of seconds')
    return value


def image_file(path: Path | None) -> Path | None:
    """Refuse an image file with an unknown ending or a missing folder."""
    if path is not None and path.suffix.lower() not in IMAGES:
        raise typer.BadParameter(f'{path} ends in {path.suffix!r}, expected {", ".join(IMAGES)}')
    if path is not None and not path.resolve().parent.is_dir():
        raise typer.BadParameter(f'{path}: there is no folder {path.resolve().parent}')
    return path
