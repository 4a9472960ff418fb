"""
On which side of the boundaries of zones and lines tracks are, and whether they crossed them.

A side is decided where the probability of being on it exceeds that of the zone or line. Near a
boundary it is that of a half-plane: of distance over the standard deviation across the boundary,
by the track's covariance. In between the last decided side holds, so noise does not count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from mctrack_ros.zones.shapes import Point, Zones

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class Look:
    """
    Where (n,) tracks are, relative to the z zones and l lines of a site: s in all.

    Attributes
    ----------
    inside : (n, z) bool array
        Whether they are in a zone.
    is_sure : (n, s) bool array
        Whether that side of the boundary, or of the line, is decided.
    squared : (n, s) float array
        Squared distance to the boundary or line, m².
    variance : (n, s) float array
        Of the distance, times the squared distance, m⁴.

    """

    inside: Flags
    is_sure: Flags
    squared: Floats
    variance: Floats

    def probability(self, row: NDArray[np.intp], shape: NDArray[np.intp]) -> Floats:
        """Return that tracks are on their side of a zone or line, (k,), by rows and indices."""
        with np.errstate(divide='ignore', invalid='ignore'):
            deviations = self.squared[row, shape] / np.sqrt(self.variance[row, shape])
        return np.asarray(ndtr(deviations))


class Sides:
    """
    The boundaries of the zones and lines of a site.

    Parameters
    ----------
    zones : Zones
        In the coordinates of the tracks.

    Attributes
    ----------
    zones : int
        How many of them are zones.
    level : (s,) float array
        Probability from which a side is decided, of each.

    """

    def __init__(self, zones: Zones) -> None:
        self.zones = len(zones.zones)
        outlines = [(*each.corners, each.corners[0]) for each in zones.zones]
        outlines += [each.points for each in zones.lines]
        self._begin, self._edge = _edges(outlines)
        length = np.square(self._edge).sum(axis=-1)
        self._scale = 1.0 / np.where(length > 0.0, length, 1.0)
        self.level = np.array(zones.levels, np.float64)
        self._sigmas = np.square(ndtri(self.level))

    def look(self, position: Floats, covariance: Floats) -> Look:
        """
        Return on which sides tracks are.

        Parameters
        ----------
        position : (n, 2) array
            Where they are, m.
        covariance : (n, 2, 2) array
            Of that, m².

        """
        away = position[:, None, None, :] - self._begin
        along = np.einsum('nsek,sek->nse', away, self._edge) * self._scale
        from_edge = away - np.clip(along, 0.0, 1.0)[..., None] * self._edge
        squared = np.einsum('nsek,nsek->nse', from_edge, from_edge)
        nearest = np.argmin(squared, axis=2)[:, :, None]
        across = np.take_along_axis(from_edge, nearest[..., None], axis=2)[:, :, 0]
        least = np.take_along_axis(squared, nearest, axis=2)[:, :, 0]
        variance = np.maximum(np.einsum('nsj,njk,nsk->ns', across, covariance, across), 0.0)
        is_sure = np.square(least) > self._sigmas * variance
        return Look(self._inside(away), is_sure, least, variance)

    def crossed(self, begin: Floats, end: Floats, line: NDArray[np.intp]) -> NDArray[np.int8]:
        """
        Return who crosses a line on the straight way: 1 to its left, -1 to its right, 0 not.

        Parameters
        ----------
        begin, end : (k, 2) array
            From where to where, m.
        line : (k,) int array
            Index of the line among the lines.

        """
        first, edge = self._begin[self.zones + line], self._edge[self.zones + line]
        step, last = (end - begin)[:, None], first + edge
        side_from = _cross(edge, begin[:, None] - first) > 0.0
        side_to = _cross(edge, end[:, None] - first) > 0.0
        parted = _cross(step, first - begin[:, None]) > 0.0
        parted ^= _cross(step, last - begin[:, None]) > 0.0
        ways = (side_to.astype(np.int8) - side_from) * parted
        return np.asarray(np.sign(ways.sum(axis=1)), np.int8)

    def _inside(self, away: Floats) -> Flags:
        """Return which of (n, s, e, 2) ways from the edges' beginnings end in a zone, (n, z)."""
        x, y = np.moveaxis(away[:, : self.zones], -1, 0)
        dx, dy = np.moveaxis(self._edge[: self.zones], -1, 0)
        is_level = (y >= 0.0) != (y >= dy)
        is_left = np.where(dy > 0.0, x * dy < y * dx, x * dy > y * dx)
        return np.asarray(np.logical_xor.reduce(is_level & is_left, axis=2))


def _edges(outlines: list[tuple[Point, ...]]) -> tuple[Floats, Floats]:
    """Return where the edges of outlines begin, and what leads to their ends, (s, e, 2)."""
    most = max(map(len, outlines), default=2)
    padded = [(*points, *[points[-1]] * (most - len(points))) for points in outlines]
    points = np.array(padded, np.float64).reshape(len(outlines), most, 2)
    return points[:, :-1], np.diff(points, axis=1)


def _cross(one: Floats, other: Floats) -> Floats:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
