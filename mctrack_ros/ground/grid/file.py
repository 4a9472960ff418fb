"""A transformation grid's XML file (event-tracking paper, Algorithm 2), field of view included."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from lxml import etree

from mctrack_ros.ground.errors import GridError
from mctrack_ros.ground.grid.checks import grid_flaws
from mctrack_ros.ground.grid.transformation_grid import TransformationGrid
from mctrack_ros.ground.xml_files import read_checked, tag, write_lines


def read_grid(path: str | Path) -> TransformationGrid:
    """
    Read a transformation-grid XML file; entities are refused.

    Raises
    ------
    GridError
        If the file cannot be read, breaks the schema, or its points cannot be where they are said
        to be (`grid_flaws`, `TransformationGrid.check_size`); names file, line and reason.

    """
    root = read_checked(path, 'workstation', GridError)
    cells, fov = root.findall('cell'), root.find('fov')
    table = np.array([[_numbers(point) for point in cell] for cell in cells])
    grid = TransformationGrid(
        root.get('id', ''),
        tuple(tuple(point.get('name', '') for point in cell) for cell in cells),
        table[..., :2],
        table[..., 2:],
        None if fov is None else np.array([_numbers(corner, ('xr', 'yr')) for corner in fov]),
        _size(root, path),
        tuple(cell.get('id', '') for cell in cells),
    )
    for cell, reason in grid_flaws(grid):
        line = cells[cell].sourceline if cell >= 0 or fov is None else fov.sourceline
        raise GridError(f'{path}:{line}: {reason}')
    if grid.image_size is not None:
        try:
            grid.check_size(grid.image_size)
        except GridError as error:
            raise GridError(f'{path}: {error}') from error
    return grid


def write_grid(grid: TransformationGrid, path: str | Path) -> None:
    """
    Write a transformation grid as XML, in full precision.

    What was read from a file of its own is written back identically; into one that a person
    wrote, `mctrack_ros.ground.grid.edit.write_fov` changes the field of view alone.
    """
    width, height = grid.image_size or (None, None)
    size = {} if width is None or height is None else {'width': str(width), 'height': str(height)}
    lines = [tag('workstation', end='', id=grid.workstation, **size)]
    ids = grid.cell_ids or tuple(str(index) for index in range(len(grid.names)))
    for cell_id, names, ground, image in zip(
        ids, grid.names, grid.ground, grid.image, strict=True
    ):
        lines.append('  ' + tag('cell', end='', id=cell_id))
        for name, (xr, yr), (xi, yi) in zip(names, ground.tolist(), image.tolist()):
            lines.append('    ' + tag('point', name=name, xr=xr, yr=yr, xi=xi, yi=yi))
        lines.append('  </cell>')
    if grid.fov is not None:
        corners = ['    ' + tag('corner', xr=x, yr=y) for x, y in grid.fov.tolist()]
        lines += ['  <fov>', *corners, '  </fov>']
    write_lines(path, [*lines, '</workstation>'])


def _numbers(
    element: etree._Element, names: tuple[str, ...] = ('xr', 'yr', 'xi', 'yi')
) -> list[float]:
    return [float(element.get(name, 'nan')) for name in names]


def _size(root: etree._Element, path: str | Path) -> tuple[int, int] | None:
    width, height = root.get('width'), root.get('height')
    if (width is None) != (height is None):
        raise GridError(f'{path}:{root.sourceline}: name both width and height, or neither')
    return None if width is None or height is None else (int(width), int(height))
