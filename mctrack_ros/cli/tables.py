"""Clouds and figures as tables that people can read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
from numpy.typing import NDArray
from rich import box
from rich.table import Table

from mctrack_ros.codec import fields_of_cloud, stamp_ns_of

if TYPE_CHECKING:
    from mctrack_ros.evaluation.figures import Figures
    from mctrack_ros.ground import CalibrationCheck

_WIDE = 8
"""Longer fields are cut down: ids to those that are not zero, numbers to their count."""


def show_figures(figures: Figures, json_file: Path | None) -> None:
    """Print figures; write them into a file, too, if one is named."""
    typer.echo(figures.table())
    if json_file is not None:
        figures.write(json_file)


def cloud_table(topic: str, message: Any) -> Table:
    """Return the rows of a cloud as a table, a column a field."""
    stamp = stamp_ns_of(message) * 1e-9
    title = f'{topic}  t = {stamp:.3f} s  {message.width} rows'
    table = Table(title=title, title_justify='left', box=box.SIMPLE_HEAD)
    fields = fields_of_cloud(message)
    for name in fields:
        table.add_column(name, justify='right', no_wrap=True)
    for row in range(message.width):
        table.add_row(*(_cell(values[row]) for values in fields.values()))
    return table


def cloud_values(topic: str, message: Any) -> dict[str, Any]:
    """Return the rows of a cloud as plain lists, for JSON."""
    fields = {name: _plain(values) for name, values in fields_of_cloud(message).items()}
    return {'topic': topic, 'stamp_ns': stamp_ns_of(message), 'fields': fields}


def check_table(checks: Mapping[str, CalibrationCheck]) -> Table:
    """Return the calibrations of cameras as a table, a row a camera."""
    table = Table(box=box.SIMPLE_HEAD)
    titles = ('points', 'fit px', 'left out px', 'worst', 'ground m')
    table.add_column('camera', no_wrap=True)
    for title in titles:
        table.add_column(title, justify='right', no_wrap=True)
    table.add_column('verdict', no_wrap=True)
    for camera, check in checks.items():
        known = np.isfinite(check.left_out_px)
        worst = int(np.nanargmax(check.left_out_px)) if known.any() else None
        table.add_row(
            camera,
            str(len(check.names)),
            f'{check.rms_px:.2f}',
            f'{check.left_out_rms_px:.2f}',
            '-' if worst is None else f'{check.names[worst]}: {check.left_out_px[worst]:.1f}',
            f'{check.deviation_m:.3f}',
            'refused' if check.refusal else 'accepted',
        )
    return table


def _plain(values: NDArray[Any]) -> list[Any]:
    """Return nested lists with None where a number is not finite: JSON knows no NaN."""
    if values.dtype.kind != 'f':
        return list(values.tolist())
    objects = values.astype(object)
    objects[~np.isfinite(values)] = None
    return list(objects.tolist())


def _cell(value: NDArray[Any]) -> str:
    if np.ndim(value) == 0:
        return _number(value)
    if len(value) > _WIDE and not value.any():
        return '-'
    if len(value) > _WIDE and value.dtype.kind == 'f':
        return f'{len(value)} numbers'
    if len(value) > _WIDE:
        value = value[value != 0]
    return ' '.join(_number(each) for each in value)


def _number(value: Any) -> str:
    return f'{float(value):.3g}' if np.asarray(value).dtype.kind == 'f' else str(int(value))
