"""A blob's foreground in cells, in which bodies are placed."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.sizes import SizeTable
from mctrack_ros.tracking.appearance import colour_likelihood

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
TALLEST = 1.15  # height of a body at most, in usual heights
HEIGHT_STEP_M = 0.05
RARE = 0.01  # likelihood of a colour that was not seen before
Place = tuple[int, int]
Body = tuple[Place, float]  # foot's cell and height, m


class Canvas:
    """
    The blob's mask in cells, with every place where a body may stand.

    A place is a cell (row, column) at the middle of the body's lower edge. Around the blob lies a
    margin of background into which bodies may reach.

    Parameters
    ----------
    image, mask : (h, w, 3) and (h, w) uint8 arrays
        The picture and its cleaned foreground, reduced by `scale`.
    box : (4,) array
        The blob, px.
    scale : float
        Pixels of the picture to one of the mask.
    sizes : SizeTable
        Of the camera.
    height_m, width_m : float
        A usual height, and the width of all bodies, m.
    cells : int
        Cells to the usual height.
    background_weight : float
        Cost of background under a body, foreground being worth 1.

    """

    def __init__(
        self,
        image: NDArray[np.uint8],
        mask: NDArray[np.uint8],
        box: Floats,
        scale: float,
        sizes: SizeTable,
        height_m: float,
        width_m: float,
        cells: int,
        background_weight: float,
    ) -> None:
        left, top, width, height = box.tolist()
        middle = left + width / 2
        expected = float(sizes.per_metre(np.array([[middle, top + height]]))[0, 1]) * height_m
        step = max(expected / cells, scale)
        columns, rows = max(1, math.ceil(width / step)), max(1, math.ceil(height / step))
        first = round(left / scale), round(top / scale)
        last = round((left + width) / scale), round((top + height) / scale)
        part = np.s_[first[1] : last[1], first[0] : last[0]]
        self._picture = image[part]
        foreground = cv2.resize(mask[part], (columns, rows), interpolation=cv2.INTER_AREA)
        self.shape = (rows, columns)
        self._step = step
        self._feet = left + (np.arange(columns) + 0.5) * step, top + np.arange(1, rows + 1) * step
        pixel = np.column_stack([np.full(rows, middle), self._feet[1]])
        across, self._metre = (sizes.per_metre(pixel) / step).T
        self._width = max(1, round(float(across[rows // 2]) * width_m))
        self._above = math.ceil(float(self._metre.max()) * (TALLEST * height_m + HEIGHT_STEP_M))
        self._side = side = self._width // 2
        self._foreground = np.zeros((self._above + rows, columns + self._width), np.float32)
        self._foreground[self._above :, side : side + columns] = foreground * np.float32(1 / 255)
        self._background_weight = np.float32(background_weight)
        self.value = self._valued(1.0)
        self._tops: dict[float, tuple[Ints, Floats]] = {}

    def values(self, template: Floats) -> list[NDArray[np.float32]]:
        """
        Return what each cell is worth to each of (n, 48) templates.

        Foreground of a colour that is more likely another member's is worth nothing, neither for
        nor against.
        """
        known = np.flatnonzero(template.any(axis=1))
        values = [self.value] * len(template)
        if len(known) < 2:
            return values
        rows, columns = self.shape
        picture = cv2.resize(self._picture, (columns, rows), interpolation=cv2.INTER_AREA)
        likelihood = colour_likelihood(np.asarray(picture, np.uint8), template[known]) + RARE
        share = np.minimum(len(known) * likelihood / likelihood.sum(axis=0), 1.0)
        padded = np.ones_like(self._foreground)
        for member, own in zip(known, share):
            padded[self._above :, self._side : self._side + columns] = own
            values[member] = self._valued(padded)
        return values

    def log_prior(self, predicted: Floats, precision: Floats) -> Floats:
        """Return the log-likelihood of every place given a predicted bottom centre, px."""
        across = self._feet[0][None] - predicted[0]
        down = self._feet[1][:, None] - predicted[1]
        (uu, uv), (_, vv) = precision.tolist()
        result: Floats = -0.5 * (uu * across**2 + (2 * uv * down) * across + vv * down**2)
        return result

    def _valued(self, share: NDArray[np.float32] | float) -> NDArray[np.float32]:
        weight = self._background_weight
        return np.asarray(self._foreground * (share + weight) - weight, np.float32)

    def empty(self) -> NDArray[np.float32]:
        """Return the count of bodies on each cell before there are any."""
        return np.zeros(self._foreground.shape, np.float32)

    def add(self, count: NDArray[np.float32], body: Body, number: int = 1) -> None:
        """Count a body, or with -1 take it away again, on the cells that it covers."""
        count[self._covered(*body)] += number

    def worth(
        self, value: NDArray[np.float32], count: NDArray[np.float32], height_m: float
    ) -> Floats:
        """Return what a body at every place, past those counted, is worth, as a share of it."""
        columns = self.shape[1]
        top, height = self._top(height_m)
        total = cv2.integral(value * (count == 0))
        strip = total[self._above + 1 :] - total[top]
        sums = strip[:, self._width : self._width + columns] - strip[:, :columns]
        result: Floats = sums / (height * self._width)[:, None]
        return result

    def explained(self, count: NDArray[np.float32], body: Body) -> float:
        """Return the share of a body that is foreground on which none is counted."""
        part = self._covered(*body)
        free = self._foreground[part][count[part] == 0]
        return float(free.sum()) / count[part].size

    def box(self, place: Place, height_m: float) -> list[float]:
        """Return left, top, width, height, px, of a body."""
        column, row = float(self._feet[0][place[1]]), float(self._feet[1][place[0]])
        width = self._width * self._step
        height = float(self._metre[place[0]]) * height_m * self._step
        return [column - width / 2, row - height, width, height]

    def _covered(self, place: Place, height_m: float) -> tuple[slice, slice]:
        row, column = place
        top = int(self._top(height_m)[0][row])
        return slice(top, self._above + row + 1), slice(column, column + self._width)

    def _top(self, height_m: float) -> tuple[Ints, Floats]:
        """Return upper edge, counted from the margin's, and height of a body in every row."""
        if height_m not in self._tops:
            bottom = self._above + np.arange(1, self.shape[0] + 1)
            height = np.clip(np.rint(self._metre * height_m), 1, bottom)
            self._tops[height_m] = (bottom - height).astype(np.int64), height
        return self._tops[height_m]
