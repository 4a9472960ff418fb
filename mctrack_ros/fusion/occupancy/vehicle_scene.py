"""Where vehicles can be, and what they cover there in each camera's mask."""

from __future__ import annotations

import numpy as np
import shapely
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_3D, compiled
from mctrack_ros.fusion.occupancy.scene import LEAST_SEEN, MARGIN_M, bounds, lattice
from mctrack_ros.fusion.occupancy.solver import Places
from mctrack_ros.fusion.views import Views
from mctrack_ros.interfaces import ClassCode

Floats = NDArray[np.float64]
Boxes = NDArray[np.int16]
Indices = NDArray[np.int64]

SIZE_M = (4.4, 1.8, 1.5)
"""Length, width and height of a car, m."""
CELL_M, TURNS = 0.5, 8
"""Distance of the places, m, and in how many directions, over half a circle, a car stands there:
the next is 11 degrees off at most."""
REACH_M = 1.0
"""How far a car moves in a round, m: two cells."""
LEAST_DISTANCE_M = 2.0
"""Between the middles of two cars, m: side by side they stand 2.3 m apart."""


class VehicleScene:
    """
    The places of a site where a car is looked for, in several directions each.

    Parameters
    ----------
    views : Views
        How its cameras see the ground.
    cameras : tuple of str
        Their names in the site's order.

    Attributes
    ----------
    position : (n, 2) array
        Of the places, m; y ascends.
    step : float
        Their distance, m.

    Raises
    ------
    ConfigError
        If no camera sees ground where a car would be large enough.

    """

    class_id = ClassCode.VEHICLE
    extent = SIZE_M[1:]

    def __init__(self, views: Views, cameras: tuple[str, ...]) -> None:
        mappings = [views.mappings[name] for name in cameras]
        spot, self.step = lattice(bounds(mappings, views.area, SIZE_M[2]), CELL_M)
        if views.area is not None:
            spot = spot[shapely.contains_xy(shapely.buffer(views.area, MARGIN_M), *spot.T)]
        self.position = np.repeat(spot, TURNS, axis=0)
        self._mappings = dict(zip(cameras, mappings))
        every = np.arange(len(self.position))
        self._corners = np.stack([self.corners(name, every) for name in cameras])
        self._sizes = [mapping.image_size for mapping in mappings]
        self._scaled: dict[tuple[tuple[int, int], ...], Places] = {}

    def corners(self, camera: str, cell: Indices, margin: float = 0.0) -> Floats:
        """Return the (n, 8, 2) px of a camera's images where cars in places have their corners.

        They may be longer and wider by a margin, m, at each end.
        """
        half_length, half_width = SIZE_M[0] / 2 + margin, SIZE_M[1] / 2 + margin
        turn = cell % TURNS * np.pi / TURNS
        ahead = np.column_stack([np.cos(turn), np.sin(turn)]) * half_length
        aside = np.column_stack([-np.sin(turn), np.cos(turn)]) * half_width
        base = np.stack([along * ahead + to * aside for along in (-1, 1) for to in (-1, 1)])
        ground = (base + self.position[cell]).reshape(-1, 2)
        mapping = self._mappings[camera]
        corners = [mapping.image_from_ground(ground, height) for height in (0.0, SIZE_M[2])]
        return np.stack(corners).reshape(8, -1, 2).swapaxes(0, 1)

    def holds(self, cell: Indices, position: Floats, margin: float) -> NDArray[np.bool_]:
        """Tell which positions, (n, 2) m, are in the footprint of a car in one of some places."""
        turn = cell % TURNS * np.pi / TURNS
        gap = position[:, None] - self.position[cell]
        along = gap[..., 0] * np.cos(turn) + gap[..., 1] * np.sin(turn)
        aside = gap[..., 1] * np.cos(turn) - gap[..., 0] * np.sin(turn)
        length, width = SIZE_M[0] / 2 + margin, SIZE_M[1] / 2 + margin
        return np.asarray(((abs(along) < length) & (abs(aside) < width)).any(axis=1))

    def places(self, shapes: tuple[tuple[int, int], ...]) -> Places:
        """Return where cars can be, and what they cover of masks there; see `Scene.places`."""
        if shapes not in self._scaled:
            boxes, first, outline, rows = [], [], [], 0
            for camera, ((height, width), (columns, lines)) in enumerate(zip(shapes, self._sizes)):
                scaled = self._corners[camera] * (width / columns, height / lines)
                box, begin, line = _hulls(np.ascontiguousarray(scaled), height, width)
                boxes.append(box)
                first.append(begin + rows)
                outline.append(line)
                rows += len(line)
            self._scaled = {
                shapes: Places(
                    self.position,
                    np.stack(boxes),
                    np.stack(first).astype(np.int32),
                    np.concatenate(outline),
                    REACH_M,
                    LEAST_DISTANCE_M,
                )
            }
        return self._scaled[shapes]


@compiled(
    types.Tuple([types.i2[:, ::1], types.i8[::1], types.i2[:, ::1]])(FLOATS_3D, types.i8, types.i8)
)
def _hulls(corners: Floats, height: int, width: int) -> tuple[Boxes, NDArray[np.int64], Boxes]:
    """
    Return the convex hulls of points, (n, k, 2) px, as far as a mask shows them.

    As columns `boxes`, `first` and `outline` of `Places`.
    """
    count, points = corners.shape[:2]
    box, first, columns = np.zeros((count, 4), np.int16), np.zeros(count, np.int64), 0
    for row in range(count):
        x, y = corners[row, :, 0], corners[row, :, 1]
        left, right = max(x.min(), 0.0), min(x.max(), float(width))
        top, bottom = max(y.min(), 0.0), min(y.max(), float(height))
        whole = (x.max() - x.min()) * (y.max() - y.min())
        if right > left and bottom > top and (right - left) * (bottom - top) >= LEAST_SEEN * whole:
            box[row, 0], box[row, 1] = round(left), round(top)
            box[row, 2], box[row, 3] = round(right), round(bottom)
        first[row] = columns
        columns += box[row, 2] - box[row, 0]
    outline = np.zeros((columns, 2), np.int16)
    for row in range(count):
        x, y = corners[row, :, 0], corners[row, :, 1]
        for column in range(box[row, 0], box[row, 2]):
            middle = min(max(column + 0.5, x.min()), x.max())
            top, bottom = np.inf, -np.inf
            for one in range(points):  # the hull's edges are among the lines between two points
                for other in range(points):
                    if x[one] <= middle <= x[other]:
                        wide = x[other] - x[one]
                        share = (middle - x[one]) / wide if wide > 0.0 else 0.0
                        at = y[one] + share * (y[other] - y[one])
                        top, bottom = min(top, at), max(bottom, at)
            place = first[row] + column - box[row, 0]
            outline[place, 0] = round(min(max(top, 0.0), float(height)))
            outline[place, 1] = round(min(max(bottom, 0.0), float(height)))
    return box, first, outline
