"""People and vehicles that move in the car park, without running into one another."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.carpark.activity.paths import Course
from mctrack_ros.simulation.carpark.rendering.vehicles import rotated

Floats = NDArray[np.float64]

_DISCS = np.array([(-1.4, 0.0), (0.0, 0.0), (1.4, 0.0)])
_CARS_APART_M, _WALKER_APART_M = 2.3, 1.35
_MOVING_MPS = 0.1


@dataclass(eq=False)
class Actor:
    """
    Somebody, on foot or on a bicycle, or a car.

    Attributes
    ----------
    class_id : ClassCode
        Person, bicycle or vehicle.
    party : int
        People who come together are of one party.
    first : int
        Step at which its course begins.
    course : Course
        Where it is from then on; afterwards it is gone.
    size : (3,) array
        Length, width and height, m.

    """

    class_id: ClassCode
    party: int
    first: int
    course: Course
    size: Floats

    @cached_property
    def pace(self) -> Floats:
        """Return how far it moves from each step to the next, (steps,) m."""
        place = self.course.position
        return np.asarray(np.linalg.norm(np.diff(place, axis=0, append=place[-1:]), axis=1))

    @cached_property
    def spots(self) -> Floats:
        """Return the (steps, discs, 2) middles of the discs that cover it, m."""
        place = self.course.position
        if self.class_id != ClassCode.VEHICLE:
            return place[:, None]
        return np.asarray(place[:, None] + rotated(_DISCS, self.course.heading[:, None, None]))

    @property
    def last(self) -> int:
        """Return the step after its course."""
        return self.first + len(self.course)


class Cast:
    """
    All actors so far.

    Parameters
    ----------
    period_s : float
        Time between steps, s.

    """

    def __init__(self, period_s: float) -> None:
        self._moving_m = _MOVING_MPS * period_s
        self.actors: list[Actor] = []
        self._parties = 0

    def new_party(self) -> int:
        """Return a number that no party has."""
        self._parties += 1
        return self._parties

    def collides(self, actor: Actor, *, but: Actor | None = None) -> bool:
        """Return whether an actor comes too near to a car that moves, or as one to anybody."""
        return any(self._near(actor, other) for other in self.actors if other is not but)

    def _near(self, one: Actor, other: Actor) -> bool:
        """Two people pass as they like; of cars, one that moves keeps its distance."""
        cars = [actor for actor in (one, other) if actor.class_id == ClassCode.VEHICLE]
        first, last = max(one.first, other.first), min(one.last, other.last)
        if not cars or first >= last:
            return False
        moves = np.zeros(last - first, np.bool_)
        for car in cars:
            moves |= (car.pace > self._moving_m)[first - car.first : last - car.first]
        if not moves.any():
            return False
        apart = _WALKER_APART_M if len(cars) == 1 else _CARS_APART_M
        spots = [actor.spots[first - actor.first :][moves.nonzero()] for actor in (one, other)]
        gap = np.linalg.norm(spots[0][:, :, None] - spots[1][:, None], axis=3)
        return bool((gap < apart).any())
