"""The hall: four wall cameras, groups who come in through one door, shadows towards a camera."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.cameras import Camera, looking_at
from mctrack_ros.simulation.indoor.people import street_clothes, walked
from mctrack_ros.simulation.indoor.render import PX_PER_M, IndoorRenderer, room_seen, textures
from mctrack_ros.simulation.rendering.render import darken
from mctrack_ros.simulation.rendering.sight import Layers, Sight
from mctrack_ros.simulation.rendering.silhouettes import Silhouette
from mctrack_ros.simulation.scenario import Scenario
from mctrack_ros.simulation.world import World, feet_in_view

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

LENGTH_M, WIDTH_M = 9.0, 7.0
"""The area that is tracked; its corner is the origin."""
WALL_M, CEILING_M = 0.6, 3.2
"""How far the walls stand from the area, and how high they are."""
DOOR_X, DOOR_Y, DOOR_M, DOOR_UP_M = LENGTH_M + WALL_M, WIDTH_M / 2, 1.2, 2.1
"""Middle, width and height of the only door, in the east wall."""
GROUPS = (3, 2, 3, 1, 2)
"""Sizes of the groups; the seed says in which order they come."""
SUN = np.array([-1.2, 0.0])
"""Shadow of something 1 m high, m: towards ``cam1``, opposite the door."""

_LOW = np.array([-WALL_M, -WALL_M, 0.0])
_HIGH = np.array([DOOR_X, WIDTH_M + WALL_M, CEILING_M])
_CAMERAS = (
    *((-0.45, DOOR_Y, 2.6), (LENGTH_M + 0.45, -0.45, 2.8)),
    *((LENGTH_M + 0.45, WIDTH_M + 0.45, 2.8), (LENGTH_M / 2, -0.45, 2.7)),
)
_AIM = (LENGTH_M / 2, WIDTH_M / 2, 0.6)
_FOCAL_PX = 480.0
"""Of images 768 px wide, as `looking_at` has it."""
_DAYLIGHT, _WINDOWS = (226, 214, 200), (250, 246, 240)
_FIRST_S, _EVERY_S, _HOLD_S, _STAGE_S = -4.0, (5.0, 7.0), (3.0, 6.0), 10.0
_STAYS, _MARGIN_M, _APART_M, _TOGETHER_M = 2, 1.2, 1.7, 0.35
_CLOSE_M = (1.6, 3.0)
_REACHED_M, _BEFORE_DOOR_M, _IN_DOOR_M = 0.4, 0.7, 0.2


@dataclass(frozen=True, slots=True)
class HallScenario(Scenario):
    """
    A recording of a hall of 9 x 7 m.

    Four cameras of 640 x 480 px on its walls see people 1.5 to 10 m away. They come in through
    one door, alone, in pairs and in threes, stop together twice, and leave. A low sun throws their
    ``shadows`` towards ``cam1``.
    """

    MOST_CAMERAS: ClassVar[int] = len(_CAMERAS)

    duration_s: float = 55.0
    rate_hz: float = 12.5
    cameras: int = len(_CAMERAS)
    width: int = 640
    height: int = 480
    shadows: bool = True


def hall_cameras(scenario: Scenario) -> tuple[Camera, ...]:
    """Return the cameras: opposite the door, in both corners beside it, on the south wall."""
    return tuple(
        looking_at(f'cam{number}', place, _AIM, _FOCAL_PX, scenario)
        for number, place in enumerate(_CAMERAS[: scenario.cameras], 1)
    )


def hall_landmarks() -> dict[str, tuple[float, float]]:
    """Return named places on the ground, m."""
    return {
        'south-west': (0.0, 0.0),
        'south-east': (LENGTH_M, 0.0),
        'north-east': (LENGTH_M, WIDTH_M),
        'north-west': (0.0, WIDTH_M),
        'door': (DOOR_X, DOOR_Y),
    }


def group_of(scenario: Scenario) -> NDArray[np.int64]:
    """Return everybody's group, (n,), in the order in which the groups come."""
    rng = np.random.default_rng([scenario.seed, 26])
    return np.repeat(np.arange(len(GROUPS)), rng.permutation(GROUPS))


def hall_world(scenario: HallScenario) -> World:
    """Return the world of a scenario; whoever is beyond the door is not active."""
    visit = _Visit(scenario)
    count, cameras = len(visit.group), hall_cameras(scenario)
    motion = walked(
        visit.outside,
        visit.rng.uniform(0, 2 * np.pi, count),
        np.ones((scenario.steps, count), np.bool_),
        scenario.period_s,
        visit.targets,
        _within_walls,
    )
    active = motion.position[..., 0] < DOOR_X
    return World(
        scenario=scenario,
        motion=motion,
        appearance=street_clothes(scenario.seed, count),
        cameras=cameras,
        feet_in_view=feet_in_view(motion.position, cameras) & active[:, None],
        active=active,
        parked=np.zeros_like(active),
        class_id=np.full(count, ClassCode.PERSON, np.uint8),
    )


class _Visit:
    """Where everybody wants to be: groups come in, stop together, go on, and leave."""

    def __init__(self, scenario: HallScenario) -> None:
        self.group, self.rng = group_of(scenario), np.random.default_rng([scenario.seed, 27])
        member = np.concatenate([np.arange(size) for size in np.bincount(self.group)])
        south = DOOR_Y - 2.2 - 0.9 * self.group  # where no camera looks through the door
        self.outside = np.column_stack([DOOR_X + 1.2 + 0.7 * member, south])
        self._spots, self._period = self.outside.copy(), scenario.period_s
        groups = len(GROUPS)
        self._centre, self._stage = np.full((groups, 2), np.inf), np.zeros(groups, np.int64)
        self._until = _FIRST_S + np.cumsum(self.rng.uniform(*_EVERY_S, groups))
        self._arrived = np.ones(groups, np.bool_)

    def targets(self, step: int, place: Floats) -> Floats:
        """Return where everybody wants to be next, (n, 2) m."""
        time_s = (step + 0.5) * self._period
        far = np.linalg.norm(place - self._spots, axis=1) > _REACHED_M
        for group in range(len(GROUPS)):
            if not self._arrived[group] and not far[self.group == group].any():
                self._arrived[group] = True
                self._until[group] = time_s + self.rng.uniform(*_HOLD_S)
            if time_s >= self._until[group] and self._stage[group] <= _STAYS:
                self._go_on(group, time_s)
        return _through_door(place, self._spots)

    def _go_on(self, group: int, time_s: float) -> None:
        """Send a group to its next place, or out."""
        members = self.group == group
        self._stage[group] += 1
        self._arrived[group], self._until[group] = False, time_s + _STAGE_S
        if self._stage[group] > _STAYS:
            self._spots[members], self._centre[group] = self.outside[members], np.inf
            return
        others = np.delete(self._centre, group, axis=0)
        for _ in range(50):
            centre = self._place()
            if (np.linalg.norm(others - centre, axis=1) > _APART_M).all():
                break
        self._centre[group] = centre
        size = np.count_nonzero(members)
        turn = self.rng.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(size) / size
        around = np.stack([np.cos(turn), np.sin(turn)], axis=1) * _TOGETHER_M * (size > 1)
        self._spots[members] = centre + around

    def _place(self) -> Floats:
        """Return a place in the hall, every other time close to a camera, (2,) m."""
        area = np.array([LENGTH_M, WIDTH_M])
        if self.rng.random() < 0.5:
            return self.rng.uniform(_MARGIN_M, area - _MARGIN_M)
        camera = np.array(_CAMERAS[self.rng.integers(len(_CAMERAS))][:2])
        towards = np.arctan2(*(area / 2 - camera)[::-1]) + self.rng.uniform(-0.5, 0.5)
        place = camera + self.rng.uniform(*_CLOSE_M) * np.array([np.cos(towards), np.sin(towards)])
        return np.asarray(np.clip(place, 0.6, area - 0.6))


def _through_door(place: Floats, target: Floats) -> Floats:
    """Return where people go next who can pass the east wall at the door alone."""
    crosses = (place[:, 0] > DOOR_X) != (target[:, 0] > DOOR_X)
    side = np.where(place[:, 0] > DOOR_X, _BEFORE_DOOR_M, -_BEFORE_DOOR_M)
    aligned = np.abs(place[:, 1] - DOOR_Y) < DOOR_M / 2 - _IN_DOOR_M
    door_x = DOOR_X + np.where(aligned, -side, side)
    door = np.column_stack([door_x, np.full(len(place), DOOR_Y)])
    return np.where(crosses[:, None], door, target)


def _within_walls(place: Floats) -> Floats:
    """Return the places moved out of the walls, (n, 2) m."""
    limited = np.maximum(place, -0.3)
    limited[:, 1] = np.where(
        place[:, 0] < DOOR_X, np.clip(limited[:, 1], -0.3, WIDTH_M + 0.3), place[:, 1]
    )
    aside = np.abs(limited[:, 1] - DOOR_Y) > DOOR_M / 2 - _IN_DOOR_M
    near = np.abs(limited[:, 0] - DOOR_X) < 0.3
    away = DOOR_X + np.where(limited[:, 0] < DOOR_X, -0.3, 0.3)
    limited[:, 0] = np.where(aside & near, away, limited[:, 0])
    return np.asarray(limited)


class HallSight(Sight):
    """What a camera of the hall sees: who is outside is seen through the door alone."""

    def __init__(self, world: World, camera_index: int) -> None:
        super().__init__(world, camera_index)
        self._people, camera = world, world.cameras[camera_index].at(0)
        half = DOOR_M / 2
        corners = [(-half, 0.0), (half, 0.0), (half, DOOR_UP_M), (-half, DOOR_UP_M)]
        door = camera.project([(DOOR_X, DOOR_Y + along, up) for along, up in corners])
        self._doorway = np.zeros(camera.size[::-1], np.uint8)
        cv2.fillConvexPoly(self._doorway, np.round(door - 0.5).astype(np.int32), 1)

    def layers(self, step: int) -> Layers:
        """Return everybody in the image, index and silhouette drawn alone, far ones first."""
        inside = self._people.active[step]
        shown = [
            (person, shape if inside[person] else self._through_door(shape))
            for person, shape in super().layers(step)
        ]
        return [(person, shape) for person, shape in shown if shape.cloth.size]

    def shadows(self, step: int, sun: Floats = SUN) -> Layers:
        """Return the shadows of all inside."""
        inside = self._people.active[step]
        return [layer for layer in super().shadows(step, sun) if inside[layer[0]]]

    def _through_door(self, shape: Silhouette) -> Silhouette:
        """Return what the wall leaves of somebody outside."""
        cloth = shape.cloth * self._doorway[shape.window]
        x, y, width, height = cv2.boundingRect(cloth)
        kept = np.ascontiguousarray(cloth[y : y + height, x : x + width])
        return replace(shape, left=shape.left + x, top=shape.top + y, cloth=kept)


class HallRenderer(IndoorRenderer):
    """Render one camera of the hall; any step, in any order, gives the same bytes."""

    def __init__(self, world: World, camera_index: int) -> None:
        super().__init__(world, camera_index)
        self._sight = HallSight(world, camera_index)
        self._has_shadows = world.scenario.shadows
        camera = world.cameras[camera_index].at(0)
        ends = (np.arange(length) + 0.5 for length in camera.size)
        ground = camera.ground(np.stack(np.meshgrid(*ends), axis=-1))
        self._floor = np.asarray(((ground > _LOW[:2]) & (ground < _HIGH[:2])).all(axis=-1))

    @staticmethod
    def room(camera: Camera, seed: int) -> Image:
        """Return what a camera sees of the empty hall: a door and windows in the east wall."""
        surfaces = textures(_LOW, _HIGH, np.random.default_rng([seed, 24]))
        middle, half = DOOR_Y - _LOW[1], DOOR_M / 2
        left, right = (round(float(end) * PX_PER_M) for end in (middle - half, middle + half))
        top, height, width = round(DOOR_UP_M * PX_PER_M), *surfaces[1].shape[:2]
        cv2.rectangle(surfaces[1], (left, 0), (right, top), _DAYLIGHT, -1)
        cv2.rectangle(surfaces[1], (0, top + 40), (width, height - 30), _WINDOWS, -1)
        return room_seen(camera, surfaces, _LOW, _HIGH)

    def empty(self, step: int) -> Image:
        """Return a copy of what is behind the people of a step, (height, width, 3)."""
        image = super().empty(step)
        if self._has_shadows:
            darken(image, self._sight.shadows(step), self._floor)
        return image
