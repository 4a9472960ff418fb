"""The local origin of a site, of all positions in cameras, fusion and on topics."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import ConfigError
from mctrack_ros.ground.origin import local_origin
from mctrack_ros.site.stated_origin import Origin, origin_text
from mctrack_ros.zones.shapes import Zones

FARTHEST_M = 10_000.0
"""How far from the origin a camera may be: up to there float32 keeps millimetres."""


def chosen_origin(places: Iterable[NDArray[np.float64]]) -> Origin:
    """
    Return the origin for cameras at (2,) places, m, that none was stated for.

    Zero, as long as all are at most `FARTHEST_M` from it; else whole kilometres near the middle
    camera: the same wherever the same files are read.
    """
    found = np.reshape(list(places), (-1, 2))
    if not (np.abs(found) > FARTHEST_M).any():
        return 0.0, 0.0
    x, y = local_origin(found).tolist()
    return x, y


def check_near(place: NDArray[np.float64], origin: Origin, what: str) -> None:
    """
    Refuse a camera whose positions float32 would not keep to the millimetre.

    Parameters
    ----------
    place : (2,) array
        Where it is, m.
    origin : (float, float)
        Of the site, m.
    what : str
        Which calibration it is, to name.

    Raises
    ------
    ConfigError
        Says which origin to set.

    """
    away = float(np.hypot(*(place - origin)))
    if away > FARTHEST_M:
        x, y = place.tolist()
        wanted = local_origin(place).tolist()
        raise ConfigError(
            f'{what}: the camera is at ({x:.0f}, {y:.0f}) m, {away / 1000:.0f} km from the '
            f"site's origin {origin_text(origin)}, expected at most {FARTHEST_M / 1000:.0f} km: "
            f'set origin: {wanted[0]:.0f},{wanted[1]:.0f} for all of the site, or mend the '
            'calibration'
        )


def check_zones_near(zones: Zones, origin: Origin) -> None:
    """
    Refuse zones and lines that lie where no camera may be.

    Parameters
    ----------
    zones : Zones
        In the coordinates of the site's files.
    origin : (float, float)
        Of the site, m.

    Raises
    ------
    ConfigError
        Names the zone or line.

    """
    keys = [(f'zones.{each.name}.corners', each.corners) for each in zones.zones]
    keys += [(f'lines.{each.name}.points', each.points) for each in zones.lines]
    for key, points in keys:
        away = float(np.hypot(*(np.array(points) - origin).T).max())
        if away > FARTHEST_M:
            raise ConfigError(
                f"{key} lies {away / 1000:.0f} km from the site's origin {origin_text(origin)}, "
                f'expected at most {FARTHEST_M / 1000:.0f} km, in the coordinates of the '
                'calibrations'
            )
