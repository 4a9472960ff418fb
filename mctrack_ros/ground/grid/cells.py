"""Cells of a transformation grid: which one a point is in, and each cell's own homography."""

from __future__ import annotations

import cv2
import numpy as np
from numba import types
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.compiled import (
    BOOLS_1D,
    FLOATS_1D,
    FLOATS_2D,
    FLOATS_3D,
    INTS_1D,
    INTS_2D,
    compiled,
    inner,
)
from mctrack_ros.ground.errors import GridError
from mctrack_ros.ground.grid.transformation_grid import TransformationGrid
from mctrack_ros.ground.homography.covariance import add_spread, spread_terms
from mctrack_ros.ground.homography.projective import ProjectiveMapping
from mctrack_ros.ground.mapping import GroundMapping, Mask, points_of, solve_spread
from mctrack_ros.ground.origin import local_origin
from mctrack_ros.ground.support import distance_squared, doubt, side_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
GUESSES = 128  # a side of the raster that names the first cell to try
UNIT = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
FOUND = types.Tuple([types.i8[::1], types.b1[::1]])


class Cells:
    """
    Cells of a grid, their corners in the order of the event-tracking paper's Figure 11.

    Parameters
    ----------
    ground : (c, 4, 2) array
        P11, P12, P22, P21 of each, m: least x and y first, then around with x growing first.
    image : (c, 4, 2) array
        The same corners, px.

    """

    def __init__(self, ground: Floats, image: Floats) -> None:
        self.ground, self.image = ground, image
        self.on_ground, self.in_image = CellFinder(ground), CellFinder(image)

    def __len__(self) -> int:
        """Return the number of cells."""
        return len(self.ground)

    def moved(self, by: Floats) -> Cells:
        """Return the cells where all positions are greater by (2,) m."""
        return Cells(self.ground + by, self.image) if by.any() else self

    @classmethod
    def of(cls, grid: TransformationGrid) -> Cells:
        """
        Put the corners of a grid's cells in order.

        Raises
        ------
        GridError
            If a cell is not a rectangle along the axes, or is folded in the image.

        """
        ground, image = np.empty_like(grid.ground), np.empty_like(grid.image)
        for index, (places, pixels) in enumerate(zip(grid.ground, grid.image)):
            low, high = places.min(axis=0), places.max(axis=0)
            wanted = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
            far = np.abs(wanted[:, None] - places[None]).max(axis=2)
            order = far.argmin(axis=1)
            if (
                far.min(axis=1).max() > 1e-6 * max(float((high - low).max()), 1e-9)
                or (low >= high).any()
            ):
                raise GridError(
                    f'cell {index} of {grid.workstation} is no rectangle along the axes: '
                    f'its points are {", ".join(grid.names[index])}'
                )
            ground[index], image[index] = wanted, pixels[order]
            if not cv2.isContourConvex(image[index].astype(np.float32)):
                raise GridError(
                    f'cell {index} of {grid.workstation} is folded in the image: '
                    f'are two of {", ".join(grid.names[index])} swapped?'
                )
        return cls(ground, image)


class CellMapping(GroundMapping):
    """
    Image <-> ground with a homography for each cell of a grid: exact at all four corners.

    A point outside all cells is mapped by the nearest one, and flagged by `is_extrapolated`.

    Parameters
    ----------
    cells : Cells
        Of the grid.
    image_size : (int, int)
        Width and height of the images, px.
    click_noise_px : float
        Standard deviation of a corner's pixel along one axis, carried into the covariances.

    """

    def __init__(
        self, cells: Cells, image_size: tuple[int, int], click_noise_px: float = 0.0
    ) -> None:
        self.origin = local_origin(cells.ground)
        self.cells = cells = cells.moved(-self.origin)
        self.image_size = (int(image_size[0]), int(image_size[1]))
        self._noise_px = float(click_noise_px)
        self._to_image = np.array([_exact(a, b) for a, b in zip(cells.ground, cells.image)])
        self._to_ground = np.linalg.inv(self._to_image)
        self._unit = np.array([_exact(UNIT, image) for image in cells.image])
        clicked = [_by_corners(*each) for each in zip(self._unit, cells.image) if self._noise_px]
        self._terms = np.reshape([spread_terms(each) for each in clicked], (-1, 6, 6))
        self._terms *= self._noise_px**2
        corners, where = cells.ground.reshape(-1, 2), cells.image.reshape(-1, 2)
        _, first = np.unique(corners, axis=0, return_index=True)
        self._upright = ProjectiveMapping.from_points(
            corners[first], where[first], self.image_size
        )

    @property
    def camera_position(self) -> Floats:
        """Where the camera stands, (3,) m, by one homography over all points."""
        return self._stated(self._upright.camera_position)

    def ground_from_image(self, pixel: ArrayLike) -> Floats:
        """Return the (n, 2) ground positions, m, of (n, 2) pixels; NaN beyond the horizon."""
        pixel = points_of(pixel)
        cell, _ = self.cells.in_image(pixel)
        return _mapped(self._to_ground, cell, pixel) + self.origin

    def image_from_ground(self, position: ArrayLike, height: ArrayLike = 0.0) -> Floats:
        """Return the (n, 2) pixels of (n, 2) ground positions, m; heights by one homography."""
        local = self._local(position)
        cell, _ = self.cells.on_ground(local)
        return _mapped(self._to_image, cell, local) + self.rise(position, height)

    def rise(self, position: ArrayLike, height: ArrayLike) -> Floats | float:
        """Return how far, (n, 2) px, heights, m, lie from their feet, by one homography."""
        if not np.any(height):
            return 0.0
        position = self._local(position)
        raised = self._upright.image_from_ground(position, height)
        offset: Floats = raised - self._upright.image_from_ground(position)
        return offset

    def height_doubt(self, height: float) -> float:
        """Return that nothing is known of the pose: each cell is mapped by itself."""
        return np.inf

    def image_jacobian(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) derivatives of pixels by ground positions, px/m."""
        position = self._local(position)
        cell, _ = self.cells.on_ground(position)
        return _slopes(self._to_image, cell, position)

    def is_extrapolated(self, pixel: ArrayLike) -> Mask:
        """Tell which (n, 2) pixels lie in no cell."""
        return ~self.cells.in_image(points_of(pixel))[1]

    def calibration_covariance(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) covariances, m², that the corners' clicks add at positions, m."""
        return self.ground_covariance(position, np.zeros((1, 2, 2)))

    def ground_covariance(self, position: ArrayLike, pixel_covariance: ArrayLike) -> Floats:
        """Return the (n, 2, 2) covariances, m², of positions, m, seen so well, px²."""
        position = self._local(position)
        return self._covariance(position, pixel_covariance, *self.cells.on_ground(position))

    def locate(self, pixel: ArrayLike, pixel_covariance: ArrayLike) -> tuple[Floats, Floats]:
        """Return (n, 2) positions, m, and their (n, 2, 2) covariances, m²."""
        pixel = points_of(pixel)
        cell, inside = self.cells.in_image(pixel)
        position = _mapped(self._to_ground, cell, pixel)
        covariance = self._covariance(position, pixel_covariance, cell, inside)
        return position + self.origin, covariance

    def _covariance(
        self, position: Floats, pixel_covariance: ArrayLike, cell: Ints, inside: Mask
    ) -> Floats:
        noise = np.ascontiguousarray(pixel_covariance, np.float64).reshape(-1, 2, 2)
        return _spread(
            self._to_image, self._unit, self._terms, self.cells.ground, self.cells.image, cell,
            inside, position, noise,
        )  # fmt: skip


def _exact(ground: Floats, image: Floats) -> Floats:
    """Return the homography of four points, its third coordinate above 0 among them."""
    to_image, to_ground = _from_basis(image), _from_basis(ground)
    matrix = to_image @ np.linalg.inv(to_ground)
    sign = np.sign(matrix[2] @ [*ground.mean(axis=0), 1.0])
    homography: Floats = matrix * sign / np.abs(matrix).max()
    return homography


def _by_corners(matrix: Floats, image: Floats) -> Floats:
    """Return the (9, 9) covariance of a homography of the unit square for 1 px of its corners."""
    equations, moved = np.zeros((8, 9)), np.zeros((8, 8))
    for index, (corner, pixel) in enumerate(zip(np.column_stack([UNIT, np.ones(4)]), image)):
        for axis in range(2):
            row = 2 * index + axis
            equations[row, 3 * axis : 3 * axis + 3] = corner
            equations[row, 6:] = -pixel[axis] * corner
            moved[row, row] = matrix[2] @ corner
    scale = np.linalg.norm(equations, axis=0)
    derivatives = (np.linalg.pinv(equations / scale) @ moved) / scale[:, None]
    covariance: Floats = derivatives @ derivatives.T
    return covariance


def _from_basis(corners: Floats) -> Floats:
    """Return the (3, 3) matrix that sends the projective basis to four corners."""
    points = np.column_stack([corners, np.ones(4)]).T
    basis: Floats = points[:, :3] * np.linalg.solve(points[:, :3], points[:, 3])
    return basis


@inner
def _is_within(corners: Floats, x: float, y: float) -> bool:
    """Tell whether a point is in a convex cell and on none of its edges."""
    left, right = True, True
    for corner in range(4):
        ax, ay = corners[corner]
        bx, by = corners[(corner + 1) % 4]
        side = side_of(ax, ay, bx, by, x, y)
        left &= side > 0.0
        right &= side < 0.0
    return left or right


@compiled(FOUND(FLOATS_3D, INTS_2D, FLOATS_1D, FLOATS_1D, FLOATS_2D))
def _found(
    corners: Floats, guess: Ints, low: Floats, step: Floats, points: Floats
) -> tuple[Ints, Mask]:
    cell, inside = np.zeros(len(points), np.int64), np.zeros(len(points), np.bool_)
    rows, columns = guess.shape
    for index in range(len(points)):
        x, y = points[index]
        if not (np.isfinite(x) and np.isfinite(y)):
            continue
        across, down = (x - low[0]) / step[0], (y - low[1]) / step[1]
        if 0.0 <= across < columns and 0.0 <= down < rows:
            likely = guess[int(down), int(across)]
            if _is_within(corners[likely], x, y):
                cell[index], inside[index] = likely, True
                continue
        best = np.inf
        for candidate in range(len(corners)):
            distance = distance_squared(corners[candidate], x, y)
            if distance < best:
                best, cell[index] = distance, candidate
                if distance == 0.0:
                    inside[index] = True
                    break
    return cell, inside


class CellFinder:
    """
    Finds which of some convex cells points are in, or are nearest to.

    Parameters
    ----------
    corners : (c, 4, 2) array
        Of the cells, around each.

    """

    def __init__(self, corners: Floats) -> None:
        self._corners = np.ascontiguousarray(corners, np.float64)
        self._low = self._corners.min(axis=(0, 1))
        self._step = (self._corners.max(axis=(0, 1)) - self._low) / GUESSES
        self._guess = np.zeros((GUESSES, GUESSES), np.int64)
        centre = (np.arange(GUESSES) + 0.5)[:, None] * self._step + self._low
        x, y = np.meshgrid(*centre.T)
        cell, _ = self(np.column_stack([x.ravel(), y.ravel()]))
        self._guess = cell.reshape(GUESSES, GUESSES)

    def __call__(self, points: Floats) -> tuple[Ints, Mask]:
        """
        Return the cells, (n,), of (n, 2) points, and which points are inside.

        On an edge the first of its cells counts.
        """
        return _found(self._corners, self._guess, self._low, self._step, points)


@compiled(types.f8[:, ::1](FLOATS_3D, INTS_1D, FLOATS_2D))
def _mapped(matrices: Floats, cell: Ints, points: Floats) -> Floats:
    mapped = np.full((len(points), 2), np.nan)
    for index in range(len(points)):
        matrix, (x, y) = matrices[cell[index]], points[index]
        depth = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
        if depth > 0.0:
            for axis in range(2):
                along = matrix[axis, 0] * x + matrix[axis, 1] * y + matrix[axis, 2]
                mapped[index, axis] = along / depth
    return mapped


@inner
def _slope(matrix: Floats, x: float, y: float, slope: Floats) -> None:
    """Write the (2, 2) derivatives of a homography."""
    depth = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
    share = 1.0 / depth if depth > 0.0 else np.nan
    for axis in range(2):
        along = (matrix[axis, 0] * x + matrix[axis, 1] * y + matrix[axis, 2]) * share
        for by in range(2):
            slope[axis, by] = (matrix[axis, by] - along * matrix[2, by]) * share


@compiled(types.f8[:, :, ::1](FLOATS_3D, INTS_1D, FLOATS_2D))
def _slopes(matrices: Floats, cell: Ints, points: Floats) -> Floats:
    slopes = np.empty((len(points), 2, 2))
    for index in range(len(points)):
        _slope(matrices[cell[index]], points[index, 0], points[index, 1], slopes[index])
    return slopes


@compiled(
    types.f8[:, :, ::1](
        FLOATS_3D, FLOATS_3D, FLOATS_3D, FLOATS_3D, FLOATS_3D, INTS_1D, BOOLS_1D, FLOATS_2D,
        FLOATS_3D,
    )
)  # fmt: skip
def _spread(
    matrices: Floats, unit: Floats, terms: Floats, ground: Floats, corners: Floats, cell: Ints,
    inside: Mask, position: Floats, noise: Floats,
) -> Floats:  # fmt: skip
    """Return ground covariances: of pixels, of clicks that move the cell's homography, outside."""
    spread, slope, image = np.empty((len(position), 2, 2)), np.empty((2, 2)), np.empty((2, 2))
    known = terms.size > 0
    for index in range(len(position)):
        own, (x, y) = cell[index], position[index]
        image[:] = noise[index if len(noise) > 1 else 0]
        if known:
            low, high = ground[own, 0], ground[own, 2]
            across, along = (x - low[0]) / (high[0] - low[0]), (y - low[1]) / (high[1] - low[1])
            add_spread(unit[own], terms[own], across, along, image)
        matrix = matrices[own]
        if not inside[index]:
            depth = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
            column = (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]) / depth
            row = (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]) / depth
            variance = doubt(corners[own], column, row)
            image[0, 0] += variance
            image[1, 1] += variance
        _slope(matrix, x, y, slope)
        solve_spread(slope[0, 0], slope[0, 1], slope[1, 0], slope[1, 1], image, spread[index])
    return spread
