"""From metres on the ground to longitude and latitude."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError

_SEMI_MAJOR_M = 6378137.0
_ECCENTRICITY_2 = 6.69437999014e-3
"""Of the ellipsoid of WGS 84."""


@dataclass(frozen=True, slots=True)
class GeoReference:
    """
    Where a site lies on the earth.

    The ground is taken for the plane that touches the ellipsoid at the origin: right to a
    centimetre within a kilometre of it, to a metre within ten.

    Attributes
    ----------
    latitude, longitude : float
        Of the origin of positions, degrees, WGS 84.
    bearing : float
        Where the y axis points to, clockwise from north, degrees.

    """

    latitude: float
    longitude: float
    bearing: float = 0.0

    @classmethod
    def read(cls, text: str) -> Self | None:
        """
        Read ``latitude,longitude`` or ``latitude,longitude,bearing``; None: the text is empty.

        Raises
        ------
        ConfigError
            If it is none.

        """
        if not text:
            return None
        try:
            values = [float(number) for number in text.split(',')]
        except ValueError:
            values = []
        good = len(values) in (2, 3) and all(map(math.isfinite, values))
        if not (good and abs(values[0]) < 90.0 and abs(values[1]) <= 180.0):
            raise ConfigError(
                f'geo is {text!r}, expected latitude,longitude[,bearing of the y axis] in '
                'degrees, for example 52.5145,13.2395,90'
            )
        return cls(*values)

    def degrees(self, position: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return longitudes and latitudes, (n, 2) degrees, of positions, (n, 2) m."""
        turn = math.radians(self.bearing)
        x, y = np.asarray(position, np.float64).T
        east = x * math.cos(turn) + y * math.sin(turn)
        north = y * math.cos(turn) - x * math.sin(turn)
        phi = math.radians(self.latitude)
        squared = 1.0 - _ECCENTRICITY_2 * math.sin(phi) ** 2
        transverse = _SEMI_MAJOR_M / math.sqrt(squared)
        meridian = transverse * (1.0 - _ECCENTRICITY_2) / squared
        longitude = self.longitude + np.degrees(east / (transverse * math.cos(phi)))
        latitude = self.latitude + np.degrees(north / meridian)
        return np.stack([longitude, latitude], axis=1)
