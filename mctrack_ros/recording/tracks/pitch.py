"""The pitch that sports formats measure on: metres from its centre spot, x along its length."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.recording.tables.columns import TableError

Floats = NDArray[np.float64]

_SQUARE = 0.02
"""Deviation from a rectangle that is allowed, as a share of its sides."""


@dataclass(frozen=True, slots=True)
class Pitch:
    """
    A pitch on the ground.

    Attributes
    ----------
    centre : (float, float)
        Its centre spot in the coordinates of the site's files, m.
    length, width : float
        Its sides, m; length is the longer one.
    angle : float
        Direction of its length, from -90 degrees (excluded) to 90 degrees, rad.

    """

    centre: tuple[float, float]
    length: float
    width: float
    angle: float = 0.0

    @classmethod
    def from_corners(cls, corners: Floats) -> Self:
        """
        Return the pitch with these corners, (4, 2) in m, one after the other.

        Raises
        ------
        TableError
            If they are no rectangle.

        """
        corners = np.asarray(corners, np.float64)
        if corners.shape != (4, 2):
            raise TableError(f'a pitch has four corners, not {len(corners)}')
        one, other = corners[1] - corners[0], corners[2] - corners[1]
        sides = float(np.hypot(*one)), float(np.hypot(*other))
        gap = float(np.hypot(*(corners[0] + other - corners[3])))
        skewed = abs(float(one @ other)) > _SQUARE * sides[0] * sides[1]
        if min(sides) <= 0 or skewed or gap > _SQUARE * max(sides):
            raise TableError('the corners of the pitch are those of no rectangle')
        along = one if sides[0] >= sides[1] else other
        angle = float(np.arctan2(along[1], along[0]))
        if not -np.pi / 2 < angle <= np.pi / 2:
            angle -= float(np.copysign(np.pi, angle))
        x, y = corners.mean(axis=0).tolist()
        return cls((x, y), max(sides), min(sides), angle)

    def from_ground(self, position: Floats) -> Floats:
        """Return places, (n, 2) m, from the centre spot."""
        moved: Floats = (position - self.centre) @ self._turn()
        return moved

    def to_ground(self, position: Floats) -> Floats:
        """Return places, (n, 2) m, of those from the centre spot."""
        back: Floats = position @ self._turn().T + self.centre
        return back

    def _turn(self) -> Floats:
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        return np.array([[cos, -sin], [sin, cos]])
