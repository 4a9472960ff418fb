"""The transformation grid as the event-tracking paper iterates it (section 4.4, Algorithm 3)."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_2D, FLOATS_3D, INTS_1D, compiled, inner
from mctrack_ros.ground.grid.cells import CellMapping, Cells
from mctrack_ros.ground.mapping import GroundMapping, Mask, points_of, propagated
from mctrack_ros.ground.origin import local_origin
from mctrack_ros.ground.support import cell_doubts

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
STEPS = 40
FARTHEST = 2.0
"""How far a point outside its cell is followed, in cells; beyond it is held there."""
SLOPE_STEP = 1e-5  # share of a cell by which slopes are told
SOLVED_PX = 1e-10  # far below what a place in an image tells


class IteratedMapping(GroundMapping):
    """
    Image <-> ground by equal ratios on opposite edges of a cell, equation (4) of the paper.

    The ratio is halved towards the line through the point until that is near enough, as in
    Algorithm 3 with its comparison turned the right way round. With one large cell it is the fast
    projection of the paper's reference [17]. Outside all cells the nearest is extended, and
    `is_extrapolated` tells.

    Parameters
    ----------
    cells : Cells
        Of the grid.
    image_size : (int, int)
        Width and height of the images, px.
    threshold_px : float
        Distance from the line at which the search ends; the paper's is 1 px. At 0, and outside all
        cells, the ratios of equation (4) are solved for instead of searched.
    click_noise_px : float
        Standard deviation of a corner's pixel along one axis, carried into the covariances.

    """

    def __init__(
        self,
        cells: Cells,
        image_size: tuple[int, int],
        threshold_px: float = 1.0,
        click_noise_px: float = 0.0,
    ) -> None:
        self.origin = local_origin(cells.ground)
        self.cells = cells = cells.moved(-self.origin)
        self.image_size = (int(image_size[0]), int(image_size[1]))
        self._threshold_px, self._noise_px = float(threshold_px), float(click_noise_px)
        self._exact = CellMapping(cells, image_size)

    @property
    def camera_position(self) -> Floats:
        """Where the camera stands, (3,) m, by one homography over all points."""
        return self._stated(self._exact.camera_position)

    def ground_from_image(self, pixel: ArrayLike) -> Floats:
        """Return the (n, 2) ground positions, m, of (n, 2) pixels; NaN beyond the horizon."""
        return self._found(points_of(pixel)) + self.origin

    def _found(self, pixel: Floats) -> Floats:
        """Return the positions of pixels about the origin."""
        cell, inside = self.cells.in_image(pixel)
        ratio = _ratios(self.cells.image, cell, inside, pixel, self._threshold_px)
        low, high = self.cells.ground[cell, 0], self.cells.ground[cell, 2]
        position: Floats = low + (high - low) * ratio
        beyond = np.flatnonzero(~inside)
        position[beyond[_is_nowhere(self._exact.ground_from_image(pixel[beyond]))]] = np.nan
        return position

    def image_from_ground(self, position: ArrayLike, height: ArrayLike = 0.0) -> Floats:
        """Return the (n, 2) pixels of (n, 2) ground positions, m; NaN behind the camera."""
        local = self._local(position)
        return self._shown(local) + self._exact.rise(local, height)

    def _shown(self, position: Floats) -> Floats:
        """Return the pixels of positions about the origin."""
        cell, inside = self.cells.on_ground(position)
        pixel = _crossings(self.cells.image, cell, self._ratio(position, cell))
        pixel[self._unseen(position, inside)] = np.nan
        return pixel

    def height_doubt(self, height: float) -> float:
        """Return that nothing is known of the pose: each cell is mapped by itself."""
        return np.inf

    def image_jacobian(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) derivatives of pixels by ground positions, px/m."""
        return self._slopes(self._local(position))

    def _slopes(self, position: Floats) -> Floats:
        """Return the same at positions about the origin."""
        cell, inside = self.cells.on_ground(position)
        ratio = self._ratio(position, cell)
        size = self.cells.ground[cell, 2] - self.cells.ground[cell, 0]
        jacobian = np.empty((len(position), 2, 2))
        for axis in range(2):
            step = np.zeros(2)
            step[axis] = SLOPE_STEP
            ahead = _crossings(self.cells.image, cell, ratio + step)
            behind = _crossings(self.cells.image, cell, ratio - step)
            jacobian[:, :, axis] = (ahead - behind) / (2 * SLOPE_STEP * size[:, [axis]])
        jacobian[self._unseen(position, inside)] = np.nan
        return jacobian

    def calibration_covariance(self, position: ArrayLike) -> Floats:
        """
        Return the (n, 2, 2) covariances, m², that the method adds at (n, 2) positions, m.

        The clicks of the cell's corners, as equal ratios mix them; the stop, anywhere within its
        threshold; how far equal ratios are from the cell's homography; and, outside all cells,
        what their points do not show.
        """
        local = self._local(position)
        return self._added(local, self._shown(local))

    def locate(self, pixel: ArrayLike, pixel_covariance: ArrayLike) -> tuple[Floats, Floats]:
        """Return (n, 2) positions, m, and their (n, 2, 2) covariances, m²."""
        pixel = points_of(pixel)
        local, inside = self._found(pixel), self.cells.in_image(pixel)[1]
        reached = np.where(inside[:, None], self._shown(local), pixel)
        position = local + self.origin
        return position, self.propagated(position, pixel_covariance) + self._added(local, reached)

    def _added(self, position: Floats, pixel: Floats) -> Floats:
        """Return the covariances, m², of positions about the origin, found for pixels."""
        ratio = self._ratio(position, self.cells.on_ground(position)[0])
        nearest, inside = self.cells.in_image(pixel)
        variance = self._threshold_px**2 / 3 + cell_doubts(self.cells.image, nearest, pixel)
        variance += self._noise_px**2 * (ratio**2 + (1 - ratio) ** 2).prod(axis=1)
        image, bent = np.zeros((2, len(position), 2, 2))
        image[:, [0, 1], [0, 1]] = variance[:, None]
        bend = self._exact.ground_from_image(pixel) - position
        bent[inside] = bend[inside, :, None] * bend[inside, None]
        # outside, the lines through a point may cross a second time: the direction tells nothing
        square = (bend**2).sum(axis=1)
        bent[~inside, 0, 0] = bent[~inside, 1, 1] = square[~inside]
        return propagated(self._slopes(position), image) + bent

    def is_extrapolated(self, pixel: ArrayLike) -> Mask:
        """Tell which (n, 2) pixels lie in no cell."""
        return self._exact.is_extrapolated(pixel)

    def _ratio(self, position: Floats, cell: Ints) -> Floats:
        low, high = self.cells.ground[cell, 0], self.cells.ground[cell, 2]
        ratio: Floats = (position - low) / (high - low)
        return np.clip(ratio, -FARTHEST, 1 + FARTHEST)

    def _unseen(self, position: Floats, inside: Mask) -> Ints:
        """Return the rows of positions that the nearest cell has behind the camera."""
        beyond = np.flatnonzero(~inside)
        return beyond[_is_nowhere(self._exact.image_from_ground(position[beyond]))]


def _is_nowhere(points: Floats) -> Mask:
    return np.asarray(~np.isfinite(points).all(axis=1))


@inner
def _from_line(corners: Floats, axis: int, ratio: float, x: float, y: float) -> float:
    """Return how far, px, a point is to one side of the line at a ratio of two edges."""
    first, second, third, fourth = corners[0], corners[1], corners[3], corners[2]
    if axis == 1:
        second, third = corners[3], corners[1]
    ax = first[0] + ratio * (second[0] - first[0])
    ay = first[1] + ratio * (second[1] - first[1])
    bx = third[0] + ratio * (fourth[0] - third[0])
    by = third[1] + ratio * (fourth[1] - third[1])
    length = np.hypot(bx - ax, by - ay)
    if length == 0.0:
        return float(np.hypot(x - ax, y - ay))
    return float(((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / length)


@inner
def _halved(corners: Floats, axis: int, x: float, y: float, threshold: float) -> float:
    """Return the ratio of a point inside its cell: Algorithm 3, corrected."""
    ratio, step = 0.5, 0.25
    for _ in range(STEPS):
        if abs(_from_line(corners, axis, ratio, x, y)) <= threshold:
            break
        above = abs(_from_line(corners, axis, ratio + step, x, y))
        below = abs(_from_line(corners, axis, ratio - step, x, y))
        ratio += step if above < below else -step
        step /= 2.0
    return ratio


@inner
def _extended(corners: Floats, axis: int, x: float, y: float) -> float:
    """Return the ratio of a point, in its cell or not, by secants; held at `FARTHEST`."""
    before, ratio = 0.0, 1.0
    miss_before = _from_line(corners, axis, before, x, y)
    for _ in range(STEPS):
        miss = _from_line(corners, axis, ratio, x, y)
        if abs(miss) <= SOLVED_PX or miss == miss_before:
            break
        following = ratio - miss * (ratio - before) / (miss - miss_before)
        before, miss_before = ratio, miss
        ratio = min(max(following, -FARTHEST), 1.0 + FARTHEST)
    return ratio


@compiled(types.f8[:, ::1](FLOATS_3D, INTS_1D, BOOLS_1D, FLOATS_2D, types.f8))
def _ratios(corners: Floats, cell: Ints, inside: Mask, pixel: Floats, threshold: float) -> Floats:
    ratios = np.empty((len(pixel), 2))
    for index in range(len(pixel)):
        x, y = pixel[index]
        own = corners[cell[index]]
        for axis in range(2):
            if inside[index] and threshold > 0.0:
                ratios[index, axis] = _halved(own, axis, x, y, threshold)
            else:
                ratios[index, axis] = _extended(own, axis, x, y)
    return ratios


@compiled(types.f8[:, ::1](FLOATS_3D, INTS_1D, FLOATS_2D))
def _crossings(corners: Floats, cell: Ints, ratio: Floats) -> Floats:
    """Return the pixels where the lines at two ratios of a cell's edges cross."""
    pixel = np.empty((len(ratio), 2))
    for index in range(len(ratio)):
        own = corners[cell[index]]
        r, s = ratio[index]
        ax, ay = own[0, 0] + r * (own[1, 0] - own[0, 0]), own[0, 1] + r * (own[1, 1] - own[0, 1])
        bx, by = own[3, 0] + r * (own[2, 0] - own[3, 0]), own[3, 1] + r * (own[2, 1] - own[3, 1])
        cx, cy = own[0, 0] + s * (own[3, 0] - own[0, 0]), own[0, 1] + s * (own[3, 1] - own[0, 1])
        dx, dy = own[1, 0] + s * (own[2, 0] - own[1, 0]), own[1, 1] + s * (own[2, 1] - own[1, 1])
        cross = (bx - ax) * (dy - cy) - (by - ay) * (dx - cx)
        share = ((cx - ax) * (dy - cy) - (cy - ay) * (dx - cx)) / cross if cross != 0.0 else np.nan
        pixel[index, 0], pixel[index, 1] = ax + share * (bx - ax), ay + share * (by - ay)
    return pixel
