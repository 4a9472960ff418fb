"""What goes on in a car park: people walk, meet, loiter and ride; cars come, park and leave."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.carpark import layout
from mctrack_ros.simulation.carpark.activity import paths
from mctrack_ros.simulation.carpark.activity.cast import Actor, Cast
from mctrack_ros.simulation.carpark.activity.paths import Course
from mctrack_ros.simulation.carpark.activity.routes import CORRIDORS, Routes
from mctrack_ros.simulation.carpark.layout import Bay

Floats = NDArray[np.float64]

_WALK_MPS, _RIDE_MPS = (1.05, 1.65), (3.0, 5.5)
_DOOR_M = np.array([0.2, 1.3])
_UNHURRIED_S, _SHORT_STOP_S, _LONG_STOP_S = (5.0, 9.0), (2.0, 3.2), (6.0, 10.0)


class Activities:
    """
    Make the actors of one activity; what they do is drawn.

    Parameters
    ----------
    cast : Cast
        Gives numbers of parties.
    routes : Routes
        Where people walk.
    steps, period_s : int, float
        Length of the recording and time between its steps, s.
    rng : Generator
        Draws everything else.

    """

    def __init__(
        self, cast: Cast, routes: Routes, steps: int, period_s: float, rng: np.random.Generator
    ) -> None:
        self._cast, self._routes, self._rng = cast, routes, rng
        self._steps, self._period_s = steps, period_s

    def walk(self, first: int) -> list[Actor]:
        """One person walks through."""
        corridor, start = self._routes.anywhere_outside()
        _, end = self._routes.anywhere_outside()
        if np.sign(start[0] - 20) == np.sign(end[0] - 20):
            end = self._routes.outside(corridor, 1 if start[0] < 20 else -1)
        return [self._person(first, self._walked(self._routes.between(start, end)))]

    def group(self, first: int) -> list[Actor]:
        """Two to four people walk through side by side, so close that they are one blob."""
        corridor, side = int(self._rng.integers(len(CORRIDORS))), int(self._rng.choice((-1, 1)))
        start, end = (self._routes.outside(corridor, turn * side) for turn in (1, -1))
        lead = self._walked(self._routes.between(start, end))
        party, count = self._cast.new_party(), int(self._rng.choice((2, 2, 2, 3, 4)))
        apart = self._rng.uniform(0.35, 0.5)
        actors = []
        for index in range(count):
            offset = [(index % 2) * -0.3, (index - (count - 1) / 2) * apart]
            place = lead.position + _turned(np.array(offset), lead.heading)
            place += paths.swaying(np.zeros(2), 0, len(lead), self._period_s, self._rng).position
            actors.append(self._person(first, Course(place, lead.heading), party))
        return actors

    def cross(self, first: int) -> list[Actor]:
        """Two people walk along the same corridor towards each other and pass."""
        corridor = int(self._rng.integers(len(CORRIDORS)))
        ends = [self._routes.outside(corridor, side) for side in (-1, 1)]
        ends[1][1] = ends[0][1] + self._rng.normal(scale=0.5)
        ways = [self._routes.between(ends[0], ends[1]), np.array([ends[1], ends[0]])]
        return [self._person(first, self._walked(way)) for way in ways]

    def meet(self, first: int) -> list[Actor]:
        """Two people come from different sides, talk, and go on."""
        corridor = int(self._rng.integers(len(CORRIDORS)))
        spot = self._routes.inside(corridor, 0.5)
        spots = [spot, spot + np.array([self._rng.uniform(0.5, 0.8), 0.1])]
        sides = [(-1, 1), (1, -1)]
        come = [
            self._walked(self._routes.between(self._routes.outside(corridor, side), place))
            for place, (side, _) in zip(spots, sides)
        ]
        together = max(len(course) for course in come)
        talk = round(self._rng.uniform(4.0, 9.0) / self._period_s)
        actors = []
        for course, place, (_, side) in zip(come, spots, sides):
            start = first + together - len(course)
            stay = self._swaying(course, talk)
            leave = self._walked(self._routes.between(place, self._routes.outside(corridor, side)))
            actors.append(self._person(start, course.then(stay).then(leave)))
        return actors

    def loiter(self, first: int) -> list[Actor]:
        """One person walks in, stands about, moves on a little and stands again, leaves."""
        corridor, start = self._routes.anywhere_outside()
        course, place = Course(np.empty((0, 2)), np.empty(0)), start
        for spot in (self._routes.inside(corridor), self._routes.inside(corridor)):
            course = course.then(self._walked(self._routes.between(place, spot)))
            course = course.then(self._swaying(course, self._for(_UNHURRIED_S)))
            place = course.position[-1]
        _, end = self._routes.anywhere_outside()
        return [self._person(first, course.then(self._walked(self._routes.between(place, end))))]

    def arrive(self, first: int, bay: Bay) -> list[Actor]:
        """Bring a car into a bay, where it stays; the driver steps out and walks away."""
        start_x = float(self._rng.choice((layout.FAR_LEFT_M, layout.FAR_RIGHT_M)))
        points, heading = paths.into_bay(
            np.array([bay.x, bay.y]), bay, layout.LANES_Y[bay.lane], start_x
        )
        drive = self._driven(points, heading, 4.0, 0.2)
        car = self._car(first, drive.waiting(max(self._steps - first - len(drive), 0)))
        out = first + len(drive) + self._for(_UNHURRIED_S)
        door = drive.position[-1] + self._door(bay)
        _, end = self._routes.anywhere_outside()
        return [car, self._person(out, self._from_car(door, end, bay))]

    def depart(self, first: int, car: Actor, bay: Bay) -> list[Actor]:
        """Have somebody come, get into a car and drive it away; the car given changes course."""
        place, heading = car.course.position[-1], float(car.course.heading[-1])
        _, start = self._routes.anywhere_outside()
        leave = self._from_car(place + self._door(bay), start, bay).position[::-1]
        driver = self._person(first, Course(leave, paths.headings(leave)))
        still = car.course.until(driver.last + self._for((3.0, 6.0)) - car.first)
        course = still.then(self._out_of(place, heading, bay))
        return [driver, Actor(car.class_id, car.party, car.first, course, car.size)]

    def drop_off(self, first: int) -> list[Actor]:
        """Stop a car in the lane, let somebody out, drive on."""
        lane = int(self._rng.integers(2))
        stop_x = float(self._routes.inside(1 + lane, 0.6)[0])
        near, far = self._ends(lane)
        stop = (stop_x, layout.LANES_Y[lane])
        come = self._driven(*paths.along(np.array([near, stop])), 4.0, 0.2)
        wait = self._for(_SHORT_STOP_S if self._rng.random() < 0.35 else _LONG_STOP_S)
        go = self._driven(*paths.along(np.array([stop, far])), 0.2, 4.0)
        car = self._car(first, come.waiting(wait).then(go))
        way = self._way_from(come.position[-1], lane)
        return [car, self._person(first + len(come) + max(wait // 2, 3), self._walked(way))]

    def _way_from(self, place: Floats, lane: int) -> Floats:
        """Return the way of who gets out of a car in a lane, on either side."""
        y = layout.LANES_Y[lane]
        door = place + np.array([0.2, 1.25 * self._rng.choice((-1, 1))])
        aside = np.array([door[0], CORRIDORS[1 + lane][0 if door[1] < y else 1]])
        corridor = 1 + lane + (-1 if door[1] < y else 1)  # on the side that the door is on
        end = self._routes.outside(corridor, int(self._rng.choice((-1, 1))))
        return np.concatenate([[door], self._routes.between(aside, end)])

    def drive_through(self, first: int) -> list[Actor]:
        """Drive a car along a lane."""
        ends = self._ends(int(self._rng.integers(2)))
        return [self._car(first, self._driven(*paths.along(np.array(ends)), 4.0, 4.0))]

    def _ends(self, lane: int) -> list[tuple[float, float]]:
        """Return the ends of a lane, in the direction in which it is driven."""
        y = layout.LANES_Y[lane]
        ends = [(layout.FAR_LEFT_M, y), (layout.FAR_RIGHT_M, y)]
        if self._rng.random() < 0.5:
            ends.reverse()
        return ends

    def ride(self, first: int) -> list[Actor]:
        """One person rides through on a bicycle."""
        corridor, side = int(self._rng.integers(len(CORRIDORS))), int(self._rng.choice((-1, 1)))
        ends = np.array([self._routes.outside(corridor, turn * side) for turn in (1, -1)])
        speed = self._rng.uniform(*_RIDE_MPS)
        course = paths.walked(ends, self._period_s, speed, self._rng)
        size = np.array([1.74, 0.55, self._rng.normal(1.72, 0.06)])
        return [Actor(ClassCode.BICYCLE, self._cast.new_party(), first, course, size)]

    def parked(self, bay: Bay) -> Actor:
        """Return a car that stands in a bay from the beginning."""
        place = np.array([bay.x, bay.y]) + self._rng.normal(scale=0.08, size=2)
        heading = -bay.towards * np.pi / 2 + (np.pi if self._rng.random() < 0.2 else 0.0)
        return self._car(0, paths.standing(place, heading, self._steps))

    def _out_of(self, place: Floats, heading: float, bay: Bay) -> Course:
        """Return the course of a car that leaves a bay, backwards if it stands nose first."""
        y = layout.LANES_Y[bay.lane]
        side = float(self._rng.choice((-1, 1)))
        way, inward = paths.into_bay(place, bay, y, bay.x + side * (paths.TURN_M + 1.5))
        backwards = np.cos(heading - inward[-1]) > 0
        out = self._driven(way[::-1], inward[::-1] + (0 if backwards else np.pi), 0.2, 0.2)
        away = (layout.FAR_LEFT_M, layout.FAR_RIGHT_M)[int((side > 0) != backwards)]
        gone = self._driven(*paths.along(np.array([way[0], (away, y)])), 0.2, 4.0)
        return out.waiting(self._for((0.5, 1.5))).then(gone)

    def _from_car(self, door: Floats, end: Floats, bay: Bay) -> Course:
        """Return the way from a car's door, between the cars, to somewhere outside."""
        lane_y = layout.LANES_Y[bay.lane] - bay.towards * 2.2
        way = self._routes.between(np.array([door[0], lane_y]), end)
        return self._walked(np.concatenate([[door], way]))

    def _door(self, bay: Bay) -> Floats:
        """Return where somebody stands beside a car's door: on the line between bays."""
        side = float(self._rng.choice((-1, 1)))
        return np.array([side * _DOOR_M[1], _DOOR_M[0] * bay.towards])

    def _for(self, seconds: tuple[float, float]) -> int:
        return round(self._rng.uniform(*seconds) / self._period_s)

    def _walked(self, corners: Floats) -> Course:
        return paths.walked(corners, self._period_s, self._rng.uniform(*_WALK_MPS), self._rng)

    def _swaying(self, course: Course, steps: int) -> Course:
        """Return a wait at the end of a course, swaying."""
        place, heading = course.position[-1], float(course.heading[-1])
        return paths.swaying(place, heading, steps, self._period_s, self._rng)

    def _driven(self, points: Floats, heading: Floats, start: float, end: float) -> Course:
        speed = paths.lane_speed(self._rng)
        return paths.driven(points, heading, self._period_s, speed, start, end)

    def _person(self, first: int, course: Course, party: int | None = None) -> Actor:
        height = float(np.clip(self._rng.normal(1.74, 0.08), 1.5, 1.95))
        party = self._cast.new_party() if party is None else party
        return Actor(ClassCode.PERSON, party, first, course, np.array([0.4, 0.5, height]))

    def _car(self, first: int, course: Course) -> Actor:
        size = self._rng.normal((4.15, 1.72, 1.46), (0.22, 0.05, 0.06))
        return Actor(ClassCode.VEHICLE, self._cast.new_party(), first, course, size)


def _turned(offset: Floats, heading: Floats) -> Floats:
    """Return the (n, 2) of a (2,) offset, forward and left, turned by (n,) headings."""
    forward = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    left = np.stack([-forward[:, 1], forward[:, 0]], axis=1)
    return np.asarray(offset[0] * forward + offset[1] * left)
