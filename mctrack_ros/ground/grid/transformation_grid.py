"""The transformation grid of the event-tracking paper (section 4.4, Definitions 4 and 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.errors import GridError

OUTSIDE_SHARE = 0.05
"""How far outside the image a point may lie, as a share of the image's longer side."""

EVEN = 1e-3
"""How far from a whole number of steps the lines of an even grid lie, in steps."""


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
    fov : (k, 2) array or None
        Corners of the camera's field of view on the ground, m; None: not drawn.
    image_size : (int, int) or None
        Width and height of the images that the pixels belong to, px; None: not known.
    cell_ids : tuple of str
        What the cells are called; empty: they are counted.

    """

    workstation: str
    names: tuple[tuple[str, ...], ...]
    ground: NDArray[np.float64]
    image: NDArray[np.float64]
    fov: NDArray[np.float64] | None = None
    image_size: tuple[int, int] | None = None
    cell_ids: tuple[str, ...] = ()

    def points(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the distinct points: (n, 2) on the ground, m, and (n, 2) px."""
        both = np.concatenate([self.ground, self.image], axis=2).reshape(-1, 4)
        distinct = np.unique(both, axis=0)
        return distinct[:, :2], distinct[:, 2:]

    def named_points(self) -> tuple[tuple[str, ...], NDArray[np.float64], NDArray[np.float64]]:
        """Return the distinct points by name, in the grid's order: names, (n, 2) m, (n, 2) px."""
        flat = [name for cell in self.names for name in cell]
        first = [flat.index(name) for name in dict.fromkeys(flat)]
        names = tuple(flat[index] for index in first)
        return names, self.ground.reshape(-1, 2)[first], self.image.reshape(-1, 2)[first]

    def check_size(self, image_size: tuple[int, int]) -> None:
        """
        Refuse to be used for images of another size, px.

        Raises
        ------
        GridError
            If the grid names another size, or a point lies far outside the image.

        """
        width, height = image_size
        if self.image_size is not None and tuple(self.image_size) != (width, height):
            raise GridError(
                f'the grid of {self.workstation} is for images of '
                f'{self.image_size[0]} x {self.image_size[1]} px, not of {width} x {height} px'
            )
        beyond = np.maximum(-self.image, self.image - image_size).max(axis=2)
        if (beyond > OUTSIDE_SHARE * max(image_size)).any():
            cell, corner = np.unravel_index(int(beyond.argmax()), beyond.shape)
            x, y = self.image[cell, corner]
            raise GridError(
                f'point {self.names[cell][corner]!r} of {self.workstation} at pixel '
                f'({x:g}, {y:g}) is outside an image of {width} x {height} px: '
                'is the grid for another image size?'
            )


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
        If there is no complete cell, or a point is there twice.

    """
    check_points(workstation, names, ground, image)
    column, row = (_lines(np.round(axis, 6)).tolist() for axis in ground.T)
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


def _lines(along: NDArray[np.float64]) -> NDArray[np.int64]:
    """
    Return the column or row, (n,), of points by one coordinate, m.

    Where most lines lie one step apart and all lie on multiples of it, a line that was not
    clicked is missed: the cells beside it are incomplete, not twice as wide.
    """
    places, rank = np.unique(along, return_inverse=True)
    steps = np.diff(places)
    step = steps.min(initial=np.inf)
    off = np.abs(steps / step - np.round(steps / step))
    if (off > EVEN).any() or np.count_nonzero(steps < 1.5 * step) * 2 <= len(steps):
        return rank
    return np.asarray(np.round((along - places[0]) / step), np.int64)


def check_points(
    workstation: str,
    names: Sequence[str],
    ground: NDArray[np.float64],
    image: NDArray[np.float64],
) -> None:
    """
    Refuse a point that is given twice, or that is not finite.

    Raises
    ------
    GridError
        Names the points.

    """
    if len(set(names)) != len(names):
        name = next(name for name in names if list(names).count(name) > 1)
        raise GridError(f'point {name!r} of {workstation} is there twice')
    for what, points in (('place on the ground', ground), ('pixel', image)):
        seen: dict[tuple[float, ...], str] = {}
        for name, point in zip(names, np.asarray(points, np.float64)):
            if not np.isfinite(point).all():
                raise GridError(f'the {what} of point {name!r} of {workstation} is not finite')
            other = seen.setdefault(tuple(point.tolist()), name)
            if other != name:
                raise GridError(
                    f'points {other!r} and {name!r} of {workstation} have the same {what}'
                )
