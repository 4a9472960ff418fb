"""When what goes on: one activity soon after another, for the whole recording."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.cameras import Camera
from mctrack_ros.simulation.carpark import layout
from mctrack_ros.simulation.carpark.activity.activities import Activities
from mctrack_ros.simulation.carpark.activity.cast import Actor, Cast
from mctrack_ros.simulation.carpark.activity.routes import Routes
from mctrack_ros.simulation.carpark.scenario import CarParkScenario

_EMPTY_S = 6.0
_PAUSE_S = (4.5, 8.5)
_OCCUPIED = 0.6
_TRIES = 24
_MINGLE = 0.06
"""How often people are let into others' way in the image, each time that is drawn."""
_SETTLED_S = 15.0

_SHARES = {
    'walk': 0.19,
    'group': 0.09,
    'cross': 0.05,
    'meet': 0.05,
    'loiter': 0.04,
    'arrive': 0.20,
    'depart': 0.20,
    'drop_off': 0.07,
    'drive_through': 0.11,
}
"""How often each activity is tried."""

_RIDES = {'ride': 0.25}
"""The same where people come on bicycles."""
Floats = NDArray[np.float64]
_BREADTH = 0.55
"""Of somebody's box with the shadow's nearest part, in heights."""


def cast_of(scenario: CarParkScenario, camera: Camera) -> list[Actor]:
    """Return everybody and every car of a recording; the same scenario gives the same."""
    return _Schedule(scenario, camera).filled()


class _Schedule:
    """A car park that fills with activities from the first second to the last."""

    def __init__(self, scenario: CarParkScenario, camera: Camera) -> None:
        self._rng = np.random.default_rng([scenario.seed, 11])
        self._scenario, self._camera = scenario, camera
        self._cast = Cast(scenario.period_s)
        self._routes = Routes(camera, self._rng)
        self._activities = Activities(
            self._cast, self._routes, scenario.steps, scenario.period_s, self._rng
        )
        self._bays = layout.bays()
        self._in_bay: dict[int, Actor] = {}
        self._settled: dict[int, int] = {}

    def filled(self) -> list[Actor]:
        """Return all actors."""
        for index, bay in enumerate(self._bays):
            if self._rng.random() < _OCCUPIED:
                self._in_bay[index] = self._activities.parked(bay)
                self._cast.actors.append(self._in_bay[index])
        clock = _EMPTY_S
        tried = _SHARES | _RIDES if self._scenario.bicycles else _SHARES
        names, shares = list(tried), np.array(list(tried.values()))
        while clock < self._scenario.duration_s:
            name = str(self._rng.choice(names, p=shares / shares.sum()))
            first = round(clock * self._scenario.rate_hz)
            if any(self._tried(name, first) for _ in range(_TRIES)):
                clock += self._rng.uniform(*_PAUSE_S)
            else:
                clock += 0.5
        return self._cast.actors

    def _tried(self, name: str, first: int) -> bool:
        """Add an activity that begins at a step if nobody is run over and it ends in time."""
        if name == 'arrive':
            return self._arrived(first)
        if name == 'depart':
            return self._departed(first)
        make: Callable[[int], list[Actor]] = getattr(self._activities, name)
        return self._added(make(first))

    def _arrived(self, first: int) -> bool:
        free = [index for index in self._watched() if index not in self._in_bay]
        if not free:
            return False
        index = int(self._rng.choice(free))
        car, driver = actors = self._activities.arrive(first, self._bays[index])
        if not self._added(actors):
            return False
        self._in_bay[index] = car
        self._settled[index] = driver.last
        return True

    def _departed(self, first: int) -> bool:
        settled = first - round(_SETTLED_S * self._scenario.rate_hz)
        full = [
            index
            for index in self._watched()
            if index in self._in_bay and self._settled.get(index, -1_000) < settled
        ]
        if not full:
            return False
        index = int(self._rng.choice(full))
        parked = self._in_bay[index]
        driver, car = self._activities.depart(first, parked, self._bays[index])
        if not self._added([driver, car], instead_of=parked):
            return False
        del self._in_bay[index]
        self._settled.pop(index, None)
        return True

    def _watched(self) -> list[int]:
        """Return the bays that the image shows with room about them."""
        middle = layout.LENGTH_M / 2
        return [
            index
            for index, bay in enumerate(self._bays)
            if abs(bay.x - middle) < self._routes.half_width(bay.y) - 3.0
        ]

    def _added(self, actors: list[Actor], instead_of: Actor | None = None) -> bool:
        """Add actors who end in time and in whose way nobody is; of one activity they may be."""
        if max(actor.last for actor in actors) > self._scenario.steps or actors[0].first < 0:
            return False
        if any(self._cast.collides(actor, but=instead_of) for actor in actors):
            return False
        others = [actor for actor in self._cast.actors if actor is not instead_of]
        mingles = self._rng.random() < _MINGLE
        if not mingles and people_meet(actors, others, self._camera):
            return False
        self._cast.actors = others + actors
        return True


def people_meet(actors: list[Actor], others: list[Actor], camera: Camera) -> bool:
    """Return whether anybody's box in the image meets one of others' at some time."""
    mine, theirs = (
        [actor for actor in some if actor.class_id != ClassCode.VEHICLE]
        for some in (actors, others)
    )
    for one in mine:
        for other in theirs:
            first, last = max(one.first, other.first), min(one.last, other.last)
            if first < last and _meet(*(_boxes(who, first, last, camera) for who in (one, other))):
                return True
    return False


def _meet(one: Floats, other: Floats) -> bool:
    """Return whether (steps, 4) boxes, left, top, right and bottom, ever overlap."""
    apart = (one[:, :2] >= other[:, 2:]) | (other[:, :2] >= one[:, 2:])
    return bool((~apart.any(axis=1)).any())


def _boxes(person: Actor, first: int, last: int, camera: Camera) -> Floats:
    """Return where somebody is in the image, (steps, 4) px."""
    place = person.course.position[first - person.first : last - person.first]
    foot = np.pad(place, ((0, 0), (0, 1)))
    head = foot + np.array([0, 0, person.size[2]])
    low, high = camera.project(foot), camera.project(head)
    half = _BREADTH * (low[:, 1] - high[:, 1]) / 2
    return np.column_stack([low[:, 0] - half, high[:, 1], low[:, 0] + half, low[:, 1]])
