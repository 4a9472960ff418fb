"""Pedestrians apart from bicycles and vehicles, by how large they are on the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]
VEHICLE_ASPECT = 1.3
"""Width to height of the rectangle above which half that area will do: a car's side."""
MEMORY_S = 3.0
"""Time of one class that outweighs all before it; by trial on the synthetic car park, as below."""
BICYCLE_WIDTH_M, BICYCLE_LENGTH_M = 0.95, 2.2
"""Range of the width of a bicycle, m."""
BICYCLE_SPEED, BICYCLE_FILL = 2.5, 0.5
"""Least speed of one, m/s, and largest share of its rectangle that is foreground."""


@dataclass(frozen=True)
class ClassConfig:
    """What makes a vehicle."""

    vehicle_area_m2: float = parameter(
        3.0, 'bounding rectangle above which an object is a vehicle [m²]', minimum=0.0
    )
    vehicle_width_m: float = parameter(1.5, 'width from which it is one [m]', minimum=0.0)
    vehicle_height_m: float = parameter(1.5, 'height of vehicles [m]', minimum=0.1)


def looks_like_vehicle(extent: Floats, config: ClassConfig) -> Mask:
    """
    Tell which boxes are vehicles'.

    The paper splits pedestrians from vehicles without a word of how, and wants no models of
    objects. The one thing that is the same in every image is size on the ground: the end of a
    car is 1.7 m wide and fills 3 m² and more from any height, its side twice that; two
    pedestrians side by side fill as much at most, and are narrower.

    Parameters
    ----------
    extent : (n, 2) array
        Width and height of the bounding rectangles, m, as if upright.
    config : ClassConfig
        Parameters.

    """
    area, wide = extent.prod(axis=1), extent[:, 0] > VEHICLE_ASPECT * extent[:, 1]
    large = area > np.where(wide, 0.5, 1.0) * config.vehicle_area_m2
    return np.asarray(large & (extent[:, 0] >= config.vehicle_width_m))


def looks_like_bicycle(extent: Floats, fill: Floats, speed: Floats) -> Mask:
    """
    Tell which boxes are those of people on bicycles.

    They are as tall as on foot. From the side they differ in that a bicycle is longer than a
    stride, that one sees through it, and that it is faster than people walk; from the front they
    look like people.

    Parameters
    ----------
    extent : (n, 2) array
        Width and height of the bounding rectangles, m, as if upright.
    fill : (n,) array
        Share of each that is foreground.
    speed : (n,) array
        On the ground, m/s; NaN: not known.

    """
    long = (extent[:, 0] >= BICYCLE_WIDTH_M) & (extent[:, 0] <= BICYCLE_LENGTH_M)
    return np.asarray(long & (fill <= BICYCLE_FILL) & (speed >= BICYCLE_SPEED))


class ClassVotes:
    """
    The class of each object, by what it looked like for most of the time.

    Only what is whole counts: neither at the image's edge nor in a merged silhouette. One class
    leads, by so many seconds; those of others are taken from its lead (Boyer and Moore 1991,
    "MJRTY: a fast majority vote algorithm").
    """

    def __init__(self) -> None:
        self._lead: dict[int, tuple[int, float]] = {}

    def leads(self, local_id: Ints) -> tuple[Ints, Floats]:
        """Return which class leads for each, (n,), and by how much, s; 0: none does."""
        leads = [self._lead.get(one, (0, 0.0)) for one in local_id.tolist()]
        kind = np.array([kind for kind, _ in leads], np.int64)
        return kind, np.array([seconds for _, seconds in leads], np.float64)

    def count(self, local_id: Ints, look: Ints, whole: Mask, seconds: float) -> Ints:
        """
        Count one image and return the classes.

        Parameters
        ----------
        local_id : (n,) int array
            Objects; others are forgotten.
        look : (n,) int array
            `ClassCode` that each looks like.
        whole : (n,) bool array
            Which looks count.
        seconds : float
            Since the last image.

        Returns
        -------
        (n,) int64 array
            `ClassCode` of each; a guess from this image until one counted.

        """
        lead = {
            key: self._counted(key, kind, seconds * counts)
            for key, kind, counts in zip(local_id.tolist(), look.tolist(), whole.tolist())
        }
        self._lead = lead
        leader = np.array([kind for kind, _ in lead.values()], np.int64)
        ahead = np.array([seconds for _, seconds in lead.values()])
        return np.where(ahead == 0.0, look, leader)

    def _counted(self, key: int, look: int, seconds: float) -> tuple[int, float]:
        leader, ahead = self._lead.get(key, (look, 0.0))
        ahead += seconds if look == leader else -seconds
        leader = leader if ahead >= 0.0 else look
        return leader, min(abs(ahead), MEMORY_S)
