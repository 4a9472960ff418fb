"""A square of 40 x 40 m that eight cameras watch from its edges: people, and their masks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.inputs import OccupancyInput
from mctrack_ros.fusion.views import Views
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.ground.coverage.coverage import area_from
from mctrack_ros.interfaces import CameraRows, ClassCode, Detections, RowsTick
from mctrack_ros.perception.foreground import Reduction
from mctrack_ros.simulation import Camera, Scenario, World
from mctrack_ros.simulation.cameras import looking_at
from mctrack_ros.simulation.pitch.players import Motion
from mctrack_ros.simulation.rendering.appearance import Appearance
from mctrack_ros.simulation.rendering.bodies import Cloth
from mctrack_ros.simulation.rendering.sight import Sight, owners
from mctrack_ros.simulation.world import feet_in_view

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

SIDE_M = 40.0
PEOPLE = 20
RATE_HZ = 10.0
SIZE = (1280, 720)
_FOCAL_PX = 540.0
"""Of images 768 px wide, as `looking_at` has it: 71 degrees across."""
_OUT_M, _UP_M, _AIM_M = 2.0, 6.0, 0.6
_SPEED, _ACCELERATION = 1.3, 2.0
_NEAR_M, _PUSH, _ARRIVED_M = 0.9, 3.0, 0.6
_HEIGHT_M = (1.6, 1.92)
_HOLE_SHARE, _SPECK_SHARE = 0.08, 0.0005
"""Of people, and of the rest of an image, in patches of 8 px."""


def square_cameras(scenario: Scenario) -> tuple[Camera, ...]:
    """Return eight cameras in the corners and in the middles of the edges, on masts."""
    middle, cameras = SIDE_M / 2, []
    for index, angle in enumerate(np.arange(8) * np.pi / 4):
        direction = np.array([np.cos(angle), np.sin(angle)])
        direction /= np.abs(direction).max()
        place = middle + direction * (middle + _OUT_M)
        aim = middle + direction * (_AIM_M - 1) * 5
        name = f'cam{index + 1}'
        cameras.append(looking_at(name, [*place, _UP_M], [*aim, 0.0], _FOCAL_PX, scenario))
    return tuple(cameras)


def square_world(seed: int, duration_s: float) -> World:
    """Return people who cross the square between places of their choice."""
    scenario = Scenario(
        seed=seed, duration_s=duration_s, rate_hz=RATE_HZ, width=SIZE[0], height=SIZE[1]
    )
    rng = np.random.default_rng([seed, 31])
    motion, cameras = _motion(scenario, rng), square_cameras(scenario)
    active = np.ones(motion.heading.shape, np.bool_)
    return World(
        scenario=scenario,
        motion=motion,
        appearance=Appearance(
            np.zeros((PEOPLE, len(Cloth), 3), np.uint8),
            rng.uniform(*_HEIGHT_M, PEOPLE),
            np.zeros(PEOPLE, np.uint8),
        ),
        cameras=cameras,
        feet_in_view=feet_in_view(motion.position, cameras),
        active=active,
        parked=~active,
        class_id=np.full(PEOPLE, ClassCode.PERSON, np.uint8),
    )


def views_of(cameras: tuple[Camera, ...]) -> Views:
    """Return how the cameras see the square, as a calibration tells it."""
    mappings = {}
    for camera in cameras:
        focal, (x, y) = camera.focal_px, camera.principal_point
        intrinsics = np.array([[focal, 0, x], [0, focal, y], [0, 0, 1]])
        pose = np.column_stack([camera.rotation, -camera.rotation @ camera.position])
        mappings[camera.name] = ProjectiveMapping(intrinsics @ pose, camera.size)
    return Views(mappings, area_from(f'0,0,{SIDE_M:g},{SIDE_M:g}'))


def ticks_of(world: World) -> list[RowsTick[OccupancyInput]]:
    """Return the masks of all cameras, reduced as camera nodes do it, and no detections."""
    views, columns = views_of(world.views(0)), []
    for index, camera in enumerate(world.views(0)):
        sight, reduction = Sight(world, index), Reduction(views.mappings[camera.name], 1.0)
        rng = np.random.default_rng([world.scenario.seed, 32, index])
        told = []
        for step in range(world.scenario.steps):
            stamp_ns = world.scenario.stamp_ns(step)
            mask = _worn(owners(sight.layers(step), camera.size) > 0, rng)
            sighting = OccupancyInput(
                Detections.build(stamp_ns), reduction.foreground(mask, stamp_ns)
            )
            told.append(CameraRows(camera.name, sighting))
        columns.append(told)
    return [RowsTick.of(messages) for messages in zip(*columns)]


def _worn(mask: NDArray[np.bool_], rng: np.random.Generator) -> Image:
    """Return a mask, 255, with patches that are lost and specks that are nobody's."""
    height, width = mask.shape
    coarse = rng.random((height // 8 + 1, width // 8 + 1))
    chance = np.kron(coarse, np.ones((8, 8)))[:height, :width]
    kept = mask & (chance > _HOLE_SHARE)
    specks = (chance > 1 - _SPECK_SHARE) & ~mask
    return np.asarray(np.where(kept | specks, 255, 0), np.uint8)


def _motion(scenario: Scenario, rng: np.random.Generator) -> Motion:
    """Return everybody's motion; who has arrived goes on to another place."""
    period, shape = scenario.period_s, (scenario.steps, PEOPLE)
    position, velocity = np.zeros((*shape, 2)), np.zeros((*shape, 2))
    heading, stride = np.zeros(shape), np.zeros(shape)
    place, goal = (rng.uniform(1, SIDE_M - 1, (PEOPLE, 2)) for _ in range(2))
    speed, phase = np.zeros((PEOPLE, 2)), rng.uniform(0, 2 * np.pi, PEOPLE)
    facing, pace = np.zeros(PEOPLE), rng.uniform(0.6, 1.2, PEOPLE) * _SPEED
    for step in range(scenario.steps):
        gap = goal - place
        distance = np.linalg.norm(gap, axis=1)
        arrived = distance < _ARRIVED_M
        goal[arrived] = rng.uniform(1, SIDE_M - 1, (int(arrived.sum()), 2))
        wanted = gap / np.maximum(distance, 0.1)[:, None] * pace[:, None] + _aside(place)
        speed += np.clip(wanted - speed, -_ACCELERATION * period, _ACCELERATION * period)
        place = np.clip(place + speed * period, 0.0, SIDE_M)
        moved = np.hypot(*speed.T)
        facing = np.where(moved > 0.2, np.arctan2(speed[:, 1], speed[:, 0]), facing)
        phase = phase + 2 * np.pi * np.where(moved > 0.2, 0.7 + 0.12 * moved, 0) * period
        position[step], velocity[step] = place, speed
        heading[step], stride[step] = facing, phase
    return Motion(position, velocity, heading, stride)


def _aside(place: Floats) -> Floats:
    """Return the velocities that keep people from walking through one another, m/s."""
    apart = place[:, None] - place[None]
    distance = np.linalg.norm(apart, axis=2)
    push = np.maximum(_NEAR_M - distance, 0) / _NEAR_M * _PUSH * ~np.eye(len(place), dtype=bool)
    around = apart + 0.6 * np.stack([-apart[..., 1], apart[..., 0]], axis=-1)  # pass on the right
    return np.asarray((around / np.maximum(distance, 0.05)[..., None] * push[..., None]).sum(1))
