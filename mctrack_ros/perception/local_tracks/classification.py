"""Pedestrians apart from bicycles and vehicles, by how large they are on the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class ClassConfig:
    """What makes a vehicle, and how long it is remembered."""

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


@dataclass(frozen=True)
class BicycleConfig:
    """What makes a bicycle."""

    width_m: float = parameter(
        0.95, 'width from which what is fast and seen through is a bicycle [m]', minimum=0.0
    )
    length_m: float = parameter(2.2, 'width up to which it is one [m]', minimum=0.0)
    speed: float = parameter(2.5, 'speed from which it is one [m/s]', minimum=0.0)
    fill: float = parameter(
        0.5, 'share of its rectangle that is foreground, at most', minimum=0.0, maximum=1.0
    )
    height_m: float = parameter(1.7, 'height of people on bicycles [m]', minimum=0.1)

    def __post_init__(self) -> None:
        """Refuse sizes that no bicycle has."""
        if self.width_m > self.length_m:
            raise ValueError(
                f'width_m is {self.width_m}, expected at most length_m, {self.length_m}'
            )


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
    area, wide = extent.prod(axis=1), extent[:, 0] > config.vehicle_aspect * extent[:, 1]
    large = area > np.where(wide, 0.5, 1.0) * config.vehicle_area_m2
    return np.asarray(large & (extent[:, 0] >= config.vehicle_width_m))


def looks_like_bicycle(extent: Floats, fill: Floats, speed: Floats, config: BicycleConfig) -> Mask:
    """
    Tell which boxes are those of people on bicycles.

    They are as tall as on foot. What tells them from the side is that a bicycle is longer than a
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
    config : BicycleConfig
        Parameters.

    """
    low, high = config.width_m, config.length_m
    long = (extent[:, 0] >= low) & (extent[:, 0] <= high)
    return np.asarray(long & (fill <= config.fill) & (speed >= config.speed))


class ClassVotes:
    """
    The class of each object, by what it looked like for most of the time.

    Only what is whole counts: neither at the image's edge nor in a merged silhouette. One class
    leads, by so many seconds; those of others are taken from its lead (Boyer and Moore 1991,
    "MJRTY: a fast majority vote algorithm").

    Parameters
    ----------
    memory_s : float
        Longest lead, s.

    """

    def __init__(self, memory_s: float) -> None:
        self._memory_s = memory_s
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
        return leader, min(abs(ahead), self._memory_s)
