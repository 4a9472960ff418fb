"""Outlines of people on the cells of grids from coarse to fine (likelihood-grid paper, 4.1)."""

from __future__ import annotations

import hashlib
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import NO_EDGE
from mctrack_ros.perception.likelihood_grid.contours import POINTS, outlines
from mctrack_ros.perception.likelihood_grid.edges import ORIENTATIONS
from mctrack_ros.perception.likelihood_grid.oriented_distance import MARGIN_PX, NONE

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Indices = NDArray[np.int64]
Bytes = NDArray[np.uint8]

LEVELS = (4, 2, 1)
"""Cells of the finest grid along each side of a cell, from the coarsest grid: 10, 20, 40."""
LEAST_SEEN = 0.5
"""Share of an outline that must be in the image for its cell to be judged."""
DEVIATIONS_PX = (5.0, 4.0, 2.5)
"""Standard deviation R of an edge off the outline (equation 4) on each grid: those of coarse cells
are off by more."""


class Grid(NamedTuple):
    """
    The finest grid.

    Attributes
    ----------
    low, high : (2,) arrays
        Opposite corners, m.
    cells : int
        Along each side.

    """

    low: Floats
    high: Floats
    cells: int

    def centres(self, size: int = 1) -> Floats:
        """Return the centres of cells so many times as large, (n, 2) m, row by row."""
        count = self.cells // size
        x, y = (np.arange(count) + 0.5) / count * (self.high - self.low)[:, None]
        return np.asarray(self.low + np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))


class _Level(NamedTuple):
    """
    Outlines of one grid.

    Attributes
    ----------
    place : (n, 64) int array
        Of each point in the flat oriented distance; of one outside the image, 0.
    seen : (n,) array
        Points in the image; 0: the cell is not judged.
    parent : (n,) int array
        Cell of the coarser grid in which a cell lies.

    """

    place: Indices
    seen: Singles
    parent: Indices


HEAD_M = 1.75
"""A calibration is told by where it sees the ground and this height above it, m."""
MOST_KNOWN = 32  # cameras whose outlines are kept
_known: dict[str, list[_Level]] = {}
"""Outlines made before, by fingerprint: 0.1 s a camera each."""


class TemplateHierarchy:
    """
    Matches the outlines of people on a grid with edges, from coarse to fine.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.
    size : (int, int)
        Width and height of the images of which distances are given, px.
    grid : Grid
        Where people are looked for.
    height, width : float
        Of a person, m.
    shape : str
        One of `SHAPES`.

    Attributes
    ----------
    is_seen : (n,) bool array
        Which of the finest cells are judged.

    """

    def __init__(
        self,
        mapping: GroundMapping,
        size: tuple[int, int],
        grid: Grid,
        height: float,
        width: float,
        shape: str,
    ) -> None:
        self._tables = [_penalties(deviation) for deviation in DEVIATIONS_PX]
        key = _fingerprint(mapping, size, grid, f'{height} {width} {shape}')
        if key not in _known:
            scale = np.divide(size, mapping.image_size)
            levels = []
            for side in LEVELS:
                centres = grid.centres(side)
                contour, normal = outlines(mapping, centres, height, width / 2, shape)
                place, seen = _indices(contour * scale, normal, size)
                levels.append(_Level(place, seen, _parents(grid.cells // side)))
            while len(_known) >= MOST_KNOWN:
                del _known[next(iter(_known))]
            _known[key] = levels
        self._levels = _known[key]
        self.is_seen = np.asarray(self._levels[-1].seen > 0)

    def log_likelihood(self, distance: Bytes) -> Singles:
        """
        Return the log-likelihood of a person in each of the finest cells (equation 4).

        A cell is judged where its parent is more likely than the mean of its grid, else it has
        its parent's likelihood (section 4.3).

        Parameters
        ----------
        distance : (12, h, w) uint8 array
            Of `OrientedDistance`.

        Returns
        -------
        (n,) float32 array
            `NO_EDGE` to 0; NaN where too little of a person would be in the image.

        """
        flat = distance.ravel()
        likely = np.full(len(self._levels[0].place), NO_EDGE, np.float32)
        chosen = np.flatnonzero(self._levels[0].seen)
        for number, level in enumerate(self._levels):
            if number:
                parents = likely
                likely = parents[level.parent]
                above = parents > parents.mean()
                chosen = np.flatnonzero(above[level.parent] & (level.seen > 0))
            seen = level.seen[chosen]
            penalty = self._tables[number][flat[level.place[chosen]]].sum(axis=1)
            outside = (POINTS - seen) * np.float32(NO_EDGE)
            likely[chosen] = (penalty - outside) / seen
        likely[~self.is_seen] = np.nan
        return likely


def _fingerprint(mapping: GroundMapping, size: tuple[int, int], grid: Grid, solid: str) -> str:
    """Return a hash of a calibration, by where it puts the grid's cells, and of all else."""
    place = grid.centres()
    foot, head = mapping.image_from_ground(place), mapping.image_from_ground(place, HEAD_M)
    known = np.concatenate([place, foot, head, mapping.camera_position[:2][None]])
    sizes = f'{mapping.image_size} {size} {grid.cells} {solid}'
    return hashlib.sha256(known.tobytes() + sizes.encode()).hexdigest()


def _penalties(deviation_px: float) -> Singles:
    """Return the term of equation 4 for each distance, (256,)."""
    distance = np.minimum(np.arange(256.0), 3 * deviation_px)
    table = -(distance**2) / (2 * deviation_px**2)
    assert table[NONE] == NO_EDGE
    return np.asarray(table, np.float32)


def _indices(contour: Floats, normal: Floats, size: tuple[int, int]) -> tuple[Indices, Singles]:
    """Return where to look for each point of outlines, and how many are in the image."""
    columns, rows = size
    with np.errstate(invalid='ignore'):
        column, row = np.floor(contour[..., 0]), np.floor(contour[..., 1])
        inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    direction = np.mod(np.rint(np.nan_to_num(normal) * ORIENTATIONS / np.pi), ORIENTATIONS)
    padded_rows, padded_columns = rows + 2 * MARGIN_PX, columns + 2 * MARGIN_PX
    index = (direction * padded_rows + row + MARGIN_PX) * padded_columns + column + MARGIN_PX
    index = np.where(inside, index, 0).astype(np.int64)
    seen = inside.sum(axis=1)
    enough = np.where(seen >= LEAST_SEEN * POINTS, seen, 0)
    return index, np.asarray(enough, np.float32)


def _parents(count: int) -> Indices:
    """Return the cell of the next coarser grid in which each of (count, count) cells lies."""
    row, column = np.divmod(np.arange(count * count), count)
    return np.asarray(row // 2 * (count // 2) + column // 2)
