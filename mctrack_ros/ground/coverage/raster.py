"""Coverage and predicted errors of an area, cell by cell."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError, Region
from mctrack_ros.ground.coverage.view import View

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

MOST_CELLS = 4_000_000  # a map of 2 x 2 km in metres


@dataclass(frozen=True, eq=False, slots=True)
class Raster:
    """
    Coverage and predicted error cell by cell; rows grow with y, columns with x.

    Attributes
    ----------
    origin : (2,) array
        Corner of the first cell with least x and y, m.
    cell : float
        Edge of a cell, m.
    inside : (rows, columns) bool array
        Whether a cell's middle lies in the area.
    seen : (cameras, rows, columns) bool array
        Whether each camera sees the middle, inside the area.
    error : (cameras, rows, columns) array
        Standard deviation, m, of a person's position along its worst direction by each camera;
        NaN where it does not see, or does not know.
    fused : (rows, columns) array
        The same by all cameras together, their information summed; NaN where none knows.

    """

    origin: Floats
    cell: float
    inside: Mask
    seen: Mask
    error: Floats
    fused: Floats

    def moved(self, by: ArrayLike) -> Raster:
        """Return the raster where all positions are greater by (2,) m."""
        return replace(self, origin=self.origin + np.asarray(by, np.float64))

    @property
    def count(self) -> NDArray[np.int64]:
        """How many cameras see each cell, (rows, columns)."""
        return np.asarray(self.seen.sum(axis=0), np.int64)

    @property
    def best(self) -> Floats:
        """The least error of one camera, (rows, columns) m; NaN where none knows."""
        least = np.where(np.isnan(self.error), np.inf, self.error).min(axis=0, initial=np.inf)
        return np.where(np.isfinite(least), least, np.nan)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Least x, greatest x, least y and greatest y of all cells, m."""
        rows, columns = self.inside.shape
        x, y = (float(value) for value in self.origin)
        return x, x + columns * self.cell, y, y + rows * self.cell


def raster_of(views: list[View], area: Region, cell: float) -> Raster:
    """
    Return what cameras see of an area, cell by cell.

    Parameters
    ----------
    views : list of View
        One each.
    area : Polygon or MultiPolygon
        What is to be covered, m.
    cell : float
        Edge of a cell, m.

    Raises
    ------
    FieldOfViewError
        If there would be too many cells.

    """
    left, bottom, right, top = area.bounds
    columns, rows = (max(1, int(np.ceil(edge / cell))) for edge in (right - left, top - bottom))
    if columns * rows > MOST_CELLS:
        raise FieldOfViewError(
            f'{columns} x {rows} cells of {cell:g} m, expected at most {MOST_CELLS}: '
            'name a smaller area or larger cells'
        )
    x = left + (np.arange(columns) + 0.5) * cell
    y = bottom + (np.arange(rows) + 0.5) * cell
    place = np.stack(np.meshgrid(x, y), axis=-1)
    inside = np.asarray(shapely.contains_xy(area, place[..., 0], place[..., 1]), np.bool_)
    seen = np.zeros((len(views), rows, columns), np.bool_)
    error = np.full((len(views), rows, columns), np.nan)
    information = np.zeros((rows, columns, 2, 2))
    for index, view in enumerate(views):
        seen[index] = inside & shapely.contains_xy(view.field, place[..., 0], place[..., 1])
        covariance = view.covariance(place[seen[index]])
        error[index][seen[index]] = _worst(covariance)
        information[seen[index]] += _inverse(covariance)
    fused = _worst(_inverse(information.reshape(-1, 2, 2))).reshape(rows, columns)
    return Raster(
        np.array([left, bottom]), cell, inside, seen, error, np.where(fused > 0, fused, np.nan)
    )


def _worst(covariance: Floats) -> Floats:
    """Return the (n,) standard deviations of (n, 2, 2) covariances along their longest axis."""
    xx, xy, yy = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    longest = (xx + yy) / 2 + np.hypot((xx - yy) / 2, xy)
    deviation: Floats = np.sqrt(longest)
    return deviation


def _inverse(matrices: Floats) -> Floats:
    """Return the inverses of (n, 2, 2) symmetric matrices; zero where there is none."""
    xx, xy, yy = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
    scale = xx * yy - xy * xy
    regular = np.isfinite(scale) & (scale > 0)
    share = np.where(regular, 1 / np.where(regular, scale, 1), 0)
    entries = np.stack([yy, -xy, -xy, xx], axis=-1) * share[:, None]
    return np.where(regular[:, None], entries, 0).reshape(-1, 2, 2)
