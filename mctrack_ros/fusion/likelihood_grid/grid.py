"""The cameras' likelihoods together: product, smoothing, local maxima (paper, section 4.4)."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import NO_EDGE, Likelihood

Floats = NDArray[np.float64]

SIGMA_M = 0.1
"""Of the smoothing (equation 5): about a cell of the paper's finest grid."""
APART_M = 0.4
"""Of two maxima within this distance one counts: 3 sigma and a cell; shoulders are as wide."""
LEAST_CAMERAS = 2
"""Of one camera's outline alone the distance is not sure."""


class Maxima(NamedTuple):
    """
    Hypotheses of people.

    Attributes
    ----------
    position : (n, 2) array
        m.
    likelihood : (n,) array
        Mean log-likelihood of the cameras, smoothed.

    """

    position: Floats
    likelihood: Floats


class JointGrid:
    """
    The mean log-likelihood of the cameras that see each cell of a grid.

    The product of the paper's equation is its exponential, to the power of the number of cameras:
    a camera that does not see a cell counts there as the others do.

    Parameters
    ----------
    told : list of Likelihood
        Of each camera that knows something, on the same cells.

    Raises
    ------
    ValueError
        If the cells differ.

    """

    def __init__(self, likelihoods: list[Likelihood]) -> None:
        first = likelihoods[0]
        if any(not np.array_equal(each.position, first.position) for each in likelihoods[1:]):
            raise ValueError('the cameras tell likelihoods of different cells: give all one area')
        rows, columns = first.shape
        every = np.stack([each.log_likelihood for each in likelihoods]).astype(np.float64)
        seen = np.isfinite(every)
        count = seen.sum(axis=0)
        total = np.where(seen, every, 0.0).sum(axis=0)
        mean = np.where(count >= LEAST_CAMERAS, total / np.maximum(count, 1), NO_EDGE)
        self._cameras = len(likelihoods)
        self.mean: Floats = mean.reshape(rows, columns)
        place = first.position[:, :2].astype(np.float64).reshape(rows, columns, 2)
        self._low = place[0, 0]
        self._cell = (place[-1, -1] - self._low) / np.maximum([columns - 1, rows - 1], 1)

    def at(self, position: Floats) -> Floats:
        """Return the mean at (n, 2) positions, m, between the cells' centres; (n,)."""
        column, row = ((position - self._low) / self._cell).astype(np.float32).T
        picked = cv2.remap(
            self.mean.astype(np.float32),
            column.reshape(1, -1),
            row.reshape(1, -1),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return np.asarray(picked[0], np.float64)

    def maxima(self, least: float) -> Maxima:
        """Return the local maxima of the smoothed product of at least a mean (equations 5, 6)."""
        across, down = (SIGMA_M / self._cell).tolist()
        product = np.exp(self.mean * self._cameras)
        smooth = cv2.GaussianBlur(product, (0, 0), across, sigmaY=down)
        near = _disc(self._cell)
        row, column = np.nonzero((smooth >= cv2.dilate(smooth, near)) & (smooth > 0))
        likelihood = np.log(smooth[row, column]) / self._cameras
        kept = likelihood >= least
        row, column = row[kept], column[kept]
        log = np.log(smooth + 1e-300)
        offset = np.column_stack([_vertex(log, row, column, step) for step in ((0, 1), (1, 0))])
        place = self._low + (np.column_stack([column, row]) + offset) * self._cell
        alone = _strongest(place, likelihood[kept])
        return Maxima(place[alone], likelihood[kept][alone])


def _strongest(place: Floats, likelihood: Floats) -> NDArray[np.int64]:
    """Return which places have none at least as likely nearby: cells that are alike are one."""
    kept: list[int] = []
    for row in np.argsort(-likelihood, kind='stable').tolist():
        if all(np.hypot(*(place[row] - place[other])) >= APART_M / 2 for other in kept):
            kept.append(row)
    return np.array(kept, np.int64)


def _disc(cell: Floats) -> NDArray[np.uint8]:
    """Return the cells within `APART_M` of one."""
    across, down = np.floor(APART_M / cell).astype(int)
    x, y = np.arange(-across, across + 1) * cell[0], np.arange(-down, down + 1) * cell[1]
    return np.asarray(x**2 + y[:, None] ** 2 <= APART_M**2, np.uint8)


def _vertex(
    values: Floats, row: NDArray[np.int64], column: NDArray[np.int64], step: tuple[int, int]
) -> Floats:
    """Return where between cells a parabola through three has its maximum, -0.5 to 0.5."""
    rows, columns = values.shape
    inside = (row >= step[0]) & (row < rows - step[0])
    inside &= (column >= step[1]) & (column < columns - step[1])
    before = values[np.maximum(row - step[0], 0), np.maximum(column - step[1], 0)]
    after = values[np.minimum(row + step[0], rows - 1), np.minimum(column + step[1], columns - 1)]
    bend = before + after - 2 * values[row, column]
    with np.errstate(divide='ignore', invalid='ignore'):
        at = np.where(inside & (bend < 0), (before - after) / (2 * bend), 0.0)
    return np.clip(at, -0.5, 0.5)
