"""The scenes that can be simulated, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Events
from mctrack_ros.simulation.cameras import Camera, pitch5_cameras
from mctrack_ros.simulation.carpark import (
    CarParkMeter,
    CarParkRenderer,
    CarParkScenario,
    GreyCarParkScenario,
    carpark_world,
    grey_carpark_cameras,
    grey_carpark_world,
    layout,
)
from mctrack_ros.simulation.difficulty import DifficultyMeter
from mctrack_ros.simulation.indoor import (
    HallRenderer,
    HallScenario,
    IndoorMeter,
    IndoorRenderer,
    IndoorScenario,
    hall,
    hall_cameras,
    hall_landmarks,
    hall_world,
    indoor_world,
)
from mctrack_ros.simulation.indoor import layout as room
from mctrack_ros.simulation.pitch import field as pitch
from mctrack_ros.simulation.pitch.ptz import PtzCamera, PtzScenario, ptz_cameras
from mctrack_ros.simulation.rendering.render import CameraRenderer
from mctrack_ros.simulation.rendering.sight import View
from mctrack_ros.simulation.scenario import Scenario
from mctrack_ros.simulation.world import World

Image = NDArray[np.uint8]


class Renderer(Protocol):
    """Draws one camera's images."""

    def frame(self, step: int) -> tuple[Image, View]:
        """Return the image of a step and its truth."""


class Figured(Protocol):
    """Figures of difficulty."""

    def figures(self) -> dict[str, float]:
        """Return name -> number."""


class Meter(Protocol):
    """Counts how hard a recording is, view by view."""

    def add(self, view: Any, events: Events) -> None:
        """Count one image and what happened in it."""

    def result(self) -> Figured:
        """Return the figures of what was counted."""


@dataclass(frozen=True, slots=True)
class Scene:
    """
    A scene.

    Attributes
    ----------
    name : str
        Its name, also that of its site.
    scenario : type
        What it is made from.
    world : callable
        Scenario -> what goes on.
    renderer : callable
        World and index of a camera -> that camera's images.
    meter : callable
        World -> what counts its difficulty.
    cameras : callable
        Scenario -> its cameras.
    landmarks : callable
        Named places on the ground, m.
    extent_m : (float, float)
        Length and width of what is surveyed, m.
    cell_m : float
        Side of the cells of its transformation grids, m.
    lines : callable
        Lines painted on the ground, (n, 2) polylines, m.

    """

    name: str
    scenario: type[Scenario]
    world: Callable[[Any], World]
    renderer: Callable[[Any, int], Renderer]
    meter: Callable[[Any], Meter]
    cameras: Callable[[Any], tuple[Camera | PtzCamera, ...]]
    landmarks: Callable[[], Mapping[str, tuple[float, float]]]
    extent_m: tuple[float, float]
    cell_m: float
    lines: Callable[[], Sequence[NDArray[np.float64]]] = tuple


PITCH5 = Scene(
    name='pitch5',
    scenario=Scenario,
    world=World.simulated,
    renderer=CameraRenderer,
    meter=DifficultyMeter,
    cameras=pitch5_cameras,
    landmarks=pitch.landmarks,
    extent_m=(pitch.LENGTH_M, pitch.WIDTH_M),
    cell_m=8.0,
    lines=pitch.painted_lines,
)

PTZ = Scene(
    name='ptz',
    scenario=PtzScenario,
    world=World.simulated,
    renderer=CameraRenderer,
    meter=DifficultyMeter,
    cameras=ptz_cameras,
    landmarks=pitch.landmarks,
    extent_m=(pitch.LENGTH_M, pitch.WIDTH_M),
    cell_m=8.0,
    lines=pitch.painted_lines,
)

CARPARK = Scene(
    name='carpark',
    scenario=CarParkScenario,
    world=carpark_world,
    renderer=CarParkRenderer,
    meter=CarParkMeter,
    cameras=layout.carpark_cameras,
    landmarks=layout.landmarks,
    extent_m=(layout.LENGTH_M, layout.WIDTH_M),
    cell_m=5.0,
)

INDOOR = Scene(
    name='indoor',
    scenario=IndoorScenario,
    world=indoor_world,
    renderer=IndoorRenderer,
    meter=IndoorMeter,
    cameras=room.indoor_cameras,
    landmarks=room.landmarks,
    extent_m=(room.LENGTH_M, room.WIDTH_M),
    cell_m=0.6,
)

GREY_CARPARK = Scene(
    name='grey_carpark',
    scenario=GreyCarParkScenario,
    world=grey_carpark_world,
    renderer=CarParkRenderer,
    meter=CarParkMeter,
    cameras=grey_carpark_cameras,
    landmarks=layout.landmarks,
    extent_m=(layout.LENGTH_M, layout.WIDTH_M),
    cell_m=5.0,
)

HALL = Scene(
    name='hall',
    scenario=HallScenario,
    world=hall_world,
    renderer=HallRenderer,
    meter=IndoorMeter,
    cameras=hall_cameras,
    landmarks=hall_landmarks,
    extent_m=(hall.LENGTH_M, hall.WIDTH_M),
    cell_m=1.0,
)

SCENES = {scene.name: scene for scene in (PITCH5, PTZ, CARPARK, INDOOR, GREY_CARPARK, HALL)}


def scene_of(scenario: Scenario) -> Scene:
    """Return the scene that a scenario is one of."""
    return next(scene for scene in SCENES.values() if scene.scenario is type(scenario))
