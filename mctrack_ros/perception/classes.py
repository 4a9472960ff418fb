"""Pedestrians apart from vehicles, by how large they are on the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.interfaces import ClassCode

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class ClassConfig:
    """Parameters of `ClassVotes`."""

    vehicle_area_m2: float = parameter(
        3.0, 'bounding rectangle above which an object is a vehicle [m²]', minimum=0.0
    )
    vehicle_width_m: float = parameter(1.5, 'width from which it is one [m]', minimum=0.0)
    vehicle_aspect: float = parameter(
        1.3,
        'width to height of the rectangle above which half that area will do',
        minimum=0.0,
    )
    vehicle_height_m: float = parameter(1.5, 'height of vehicles [m]', minimum=0.1)
    memory_s: float = parameter(
        3.0, 'time of one class that outweighs all before it [s]', minimum=0.0
    )


def looks_like_vehicle(extent: Floats, config: ClassConfig) -> Mask:
    """
    Tell which boxes are vehicles'.

    The paper splits pedestrians from vehicles without a word of how, and wants no models of
    objects. The one thing that is the same in every picture is size on the ground: the end of a
    car is 1.7 m wide and fills 3 m² and more from any height, its side twice that; two
    pedestrians side by side fill as much at most, and are narrower.

    Parameters
    ----------
    extent : (n, 2) array
        Width and height of the bounding rectangles, m, as if upright.
    config : ClassConfig
        Parameters.

    """
    area, wide = extent.prod(axis=1), extent[:, 0] > config.vehicle_aspect * extent[:, 1]
    large = area > np.where(wide, 0.5, 1.0) * config.vehicle_area_m2
    return np.asarray(large & (extent[:, 0] >= config.vehicle_width_m))


class ClassVotes:
    """
    The class of each object, by what it looked like for most of the time.

    Only what is whole counts: neither at the picture's edge nor in a merged silhouette.

    Parameters
    ----------
    config : ClassConfig
        Parameters.

    """

    def __init__(self, config: ClassConfig) -> None:
        self._config = config
        self._votes: dict[int, float] = {}

    def balance(self, local_id: Ints) -> Floats:
        """Return for how long, (n,) s, each looked like a vehicle; below 0: like a person."""
        return np.array([self._votes.get(one, 0.0) for one in local_id.tolist()])

    def count(self, local_id: Ints, extent: Floats, whole: Mask, seconds: float) -> Ints:
        """
        Count one picture and return the classes.

        Parameters
        ----------
        local_id : (n,) int array
            Objects; others are forgotten.
        extent : (n, 2) array
            Their sizes, m; NaN where not known.
        whole : (n,) bool array
            Which sizes count.
        seconds : float
            Since the last picture.

        Returns
        -------
        (n,) int64 array
            `ClassCode` of each; a guess from this picture until one counted.

        """
        vehicle = looks_like_vehicle(extent, self._config)
        votes = {
            key: _capped(
                self._votes.get(key, 0.0) + (seconds if is_vehicle else -seconds) * counts,
                self._config.memory_s,
            )
            for key, is_vehicle, counts in zip(local_id.tolist(), vehicle.tolist(), whole.tolist())
        }
        self._votes = votes
        total = np.array(list(votes.values()))
        is_vehicle = np.where(total == 0.0, vehicle, total > 0.0)
        return np.where(is_vehicle, int(ClassCode.VEHICLE), int(ClassCode.PERSON))


def _capped(value: float, size: float) -> float:
    return max(-size, min(value, size))
