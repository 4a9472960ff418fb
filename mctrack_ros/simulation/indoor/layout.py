"""Where things are in the room: area, walls, door, cameras."""

from __future__ import annotations

from mctrack_ros.simulation.cameras import Camera, looking_at
from mctrack_ros.simulation.scenario import Scenario

LENGTH_M, WIDTH_M = 6.0, 4.2
"""The area that is tracked (paper, section 6); its corner is the origin."""
WALL_M, CEILING_M = 1.3, 3.0
"""How far the walls stand from the area, and how high they are."""
DOOR = (-0.9, 2.1)
"""Where people come in."""
_SIDES = ((-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0))
"""Where cameras hang, east and north of the middle: the paper's in the corners, then more."""
_CAMERA_OUT_M, _CAMERA_UP_M, _LOOKS_SHORT_M = 1.1, 2.75, 0.2
_FOCAL_PX = 480.0
"""Of images 768 px wide, as `looking_at` has it."""


def indoor_cameras(scenario: Scenario) -> tuple[Camera, ...]:
    """Return the first cameras below the ceiling: in the corners, then between them."""
    cameras = []
    for index, (east, north) in enumerate(_SIDES):
        edge = LENGTH_M * (1 + east) / 2, WIDTH_M * (1 + north) / 2
        place = edge[0] + east * _CAMERA_OUT_M, edge[1] + north * _CAMERA_OUT_M, _CAMERA_UP_M
        aim = LENGTH_M / 2 + east * _LOOKS_SHORT_M, WIDTH_M / 2 + north * _LOOKS_SHORT_M, 0.7
        cameras.append(looking_at(f'cam{index + 1}', place, aim, _FOCAL_PX, scenario))
    return tuple(cameras[: scenario.cameras])


def landmarks() -> dict[str, tuple[float, float]]:
    """Return named places on the ground, m."""
    return {
        'south-west': (0.0, 0.0),
        'south-east': (LENGTH_M, 0.0),
        'north-east': (LENGTH_M, WIDTH_M),
        'north-west': (0.0, WIDTH_M),
        'door': DOOR,
    }
