"""The transformation grid of the event-tracking paper: its XML file (Algorithm 2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import ParseError, parse
from numpy.typing import NDArray


class GridError(ValueError):
    """A grid file that cannot be used; names the file and the reason."""


@dataclass(frozen=True, eq=False, slots=True)
class TransformationGrid:
    """
    Ground points with their pixels, four to a cell (event-tracking paper, Definitions 4 and 5).

    Attributes
    ----------
    workstation : str
        Name of the camera.
    names : tuple of tuple of str
        Names of the points, four to a cell.
    ground : (cells, 4, 2) array
        Ground coordinates, m.
    image : (cells, 4, 2) array
        Pixels.

    """

    workstation: str
    names: tuple[tuple[str, ...], ...]
    ground: NDArray[np.float64]
    image: NDArray[np.float64]

    def points(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the distinct points: (n, 2) on the ground, m, and (n, 2) px."""
        both = np.concatenate([self.ground, self.image], axis=2).reshape(-1, 4)
        distinct = np.unique(both, axis=0)
        return distinct[:, :2], distinct[:, 2:]


def grid_from_points(
    workstation: str,
    names: Sequence[str],
    ground: NDArray[np.float64],
    image: NDArray[np.float64],
) -> tuple[TransformationGrid, tuple[str, ...]]:
    """
    Group clicked points into cells: each of four neighbours in rows and columns.

    Parameters
    ----------
    workstation : str
        Name of the camera.
    names : sequence of str
        Of the points.
    ground, image : (n, 2) arrays
        The points, m, and where they were clicked, px.

    Returns
    -------
    grid : TransformationGrid
        The complete cells.
    ignored : tuple of str
        Points of no complete cell, which are left out (event-tracking paper, section 4.4).

    Raises
    ------
    GridError
        If there is no complete cell.

    """
    column, row = (
        np.unique(np.round(axis, 6), return_inverse=True)[1].tolist() for axis in ground.T
    )
    at = {place: index for index, place in enumerate(zip(column, row))}
    cells = [
        [at[place] for place in corners]
        for x, y in sorted(at)
        if at.keys() >= set(corners := [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)])
    ]
    if not cells:
        raise GridError(
            f'the {len(names)} points of {workstation} make no complete cell: '
            'click the four corners of at least one rectangle'
        )
    used = {index for cell in cells for index in cell}
    return (
        TransformationGrid(
            workstation,
            tuple(tuple(names[index] for index in cell) for cell in cells),
            ground[cells],
            image[cells],
        ),
        tuple(name for index, name in enumerate(names) if index not in used),
    )


def read_grid(path: str | Path) -> TransformationGrid:
    """
    Read a transformation-grid XML file; entities are not expanded.

    Raises
    ------
    GridError
        If the file cannot be read, is not XML, or its cells are not of four complete points.

    """
    try:
        root = parse(str(path), forbid_dtd=True).getroot()
    except (ParseError, DefusedXmlException) as error:
        raise GridError(f'{path}: not a readable XML file: {error}') from error
    except OSError as error:
        raise GridError(f'{path}: {error.strerror or error}') from error
    if root is None or root.tag != 'workstation':
        raise GridError(
            f'{path}: the root is <{root.tag if root is not None else ""}>, expected <workstation>'
        )
    cells = root.findall('cell')
    if not cells:
        raise GridError(f'{path}: the grid has no <cell>')
    names, numbers = [], []
    for cell in cells:
        points = cell.findall('point')
        where = f'{path}: cell {cell.get("id")!r}'
        if len(points) != 4:
            raise GridError(f'{where} has {len(points)} points, expected 4')
        names.append(tuple(point.get('name', '') for point in points))
        numbers.append([_numbers(point, where) for point in points])
    table = np.asarray(numbers, np.float64)
    return TransformationGrid(root.get('id', ''), tuple(names), table[..., :2], table[..., 2:])


def write_grid(grid: TransformationGrid, path: str | Path) -> None:
    """Write a transformation grid as XML."""
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        f'<workstation id={quoteattr(grid.workstation)}>',
    ]
    for index, (names, ground, image) in enumerate(zip(grid.names, grid.ground, grid.image)):
        lines.append(f'  <cell id="{index}">')
        for name, (xr, yr), (xi, yi) in zip(names, ground.tolist(), image.tolist()):
            where = f'xr="{xr!r}" yr="{yr!r}" xi="{xi!r}" yi="{yi!r}"'
            lines.append(f'    <point name={quoteattr(name)} {where}/>')
        lines.append('  </cell>')
    lines.append('</workstation>')
    Path(path).write_text('\n'.join(lines) + '\n', encoding='utf-8')


def _numbers(point: Any, where: str) -> list[float]:
    values = []
    for attribute in ('xr', 'yr', 'xi', 'yi'):
        text = point.get(attribute)
        if text is None:
            raise GridError(f'{where}: point {point.get("name")!r} lacks {attribute}')
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise GridError(
                f'{where}: {attribute} of point {point.get("name")!r} is {text!r}, '
                'expected a finite number'
            )
        values.append(value)
    return values
