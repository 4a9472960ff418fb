"""Two cameras beside the pitch that pan, tilt and zoom about fixed centres."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d

from mctrack_ros.simulation.cameras import Camera, looking_at
from mctrack_ros.simulation.pitch.play import course_of_play
from mctrack_ros.simulation.scenario import Scenario

Floats = NDArray[np.float64]

_PLACES = {'cam1': (52.5, -37.7, 17.0), 'cam2': (-36.5, 20.0, 15.0)}
_AIMED_AT = {'cam1': ((30.0, 20.0), (75.0, 44.0)), 'cam2': ((12.0, 14.0), (45.0, 54.0))}
"""South-western and north-eastern corner of where each aims, m."""
_FOCAL_PX = 1500.0
_ZOOM = 0.15
_SWEEP_S = (16.0, 27.0, 43.0)
_SHARES = (0.25, 0.3, 0.45)
_FOLLOW_S = 1.2


@dataclass(frozen=True, slots=True)
class PtzScenario(Scenario):
    """
    A match before two cameras that pan, tilt and zoom (belief-propagation paper, section 3.3).

    Attributes
    ----------
    follows_play : bool
        Whether the cameras follow the ball; unless so, they sweep on smooth paths of the seed.
    sweep : float
        How far, as a share of the usual.

    """

    cameras: int = 2
    follows_play: bool = False
    sweep: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what cannot be simulated."""
        super(PtzScenario, self).__post_init__()
        if self.cameras > 2:
            raise ValueError(f'cameras is {self.cameras!r}, expected 1 or 2')
        if self.distortion:
            raise ValueError(
                f'distortion is {self.distortion!r}, expected 0: PTZ cameras have none'
            )


@dataclass(frozen=True, eq=False, slots=True)
class PtzCamera:
    """
    A camera that turns and zooms about a fixed centre.

    Attributes
    ----------
    steps : tuple of Camera
        The camera at every step: its true calibration.
    mosaic : Camera
        One of a larger image that holds all that is ever seen.

    """

    steps: tuple[Camera, ...]
    mosaic: Camera

    @classmethod
    def of(cls, steps: tuple[Camera, ...]) -> PtzCamera:
        """Return the camera that has these views, one a step."""
        forward = np.mean([camera.rotation[2] for camera in steps], axis=0)
        middle = steps[int(np.argmax([camera.rotation[2] @ forward for camera in steps]))]
        focal = max(camera.focal_px for camera in steps)
        corners = np.concatenate([_corner_rays(camera) for camera in steps]) @ middle.rotation.T
        reach = np.abs(corners[:, :2] / corners[:, 2:]).max(axis=0) * focal + 2
        width, height = (2 * np.ceil(reach)).astype(int).tolist()
        mosaic = Camera(middle.name, middle.position, middle.rotation, focal, (width, height))
        return cls(steps, mosaic)

    @property
    def name(self) -> str:
        """Return its name, also that of its topics."""
        return self.steps[0].name

    def at(self, step: int) -> Camera:
        """Return the camera at a step; after the last, the last."""
        return self.steps[min(step, len(self.steps) - 1)]

    def sees(self, world: ArrayLike) -> NDArray[np.bool_]:
        """Return which of (steps, ..., 3) world points fall into the image of their step."""
        return np.stack([self.at(step).sees(row) for step, row in enumerate(np.asarray(world))])


def ptz_cameras(scenario: PtzScenario) -> tuple[PtzCamera, ...]:
    """Return one camera on the main stand and one behind a goal, at nearly right angles."""
    names = list(_PLACES)[: scenario.cameras]
    return tuple(
        PtzCamera.of(tuple(_views(scenario, name, index))) for index, name in enumerate(names)
    )


def _views(scenario: PtzScenario, name: str, index: int) -> Iterator[Camera]:
    rng = np.random.default_rng([scenario.seed, 7, index])
    low, high = np.array(_AIMED_AT[name])
    aims = (low + high) / 2 + scenario.sweep * _sweep(scenario, rng, 2) * (high - low) / 2
    zoom = _sweep(scenario, rng, 1)[:, 0]
    if scenario.follows_play:
        ball = course_of_play(scenario, np.random.default_rng([scenario.seed, 1])).ball
        aims = np.clip(ball, low, high)
        aims = gaussian_filter1d(aims, _FOLLOW_S * scenario.rate_hz, axis=0, mode='nearest')
    for aim, focal in zip(aims, _FOCAL_PX * np.exp(_ZOOM * zoom)):
        yield looking_at(name, _PLACES[name], (*aim, 0.0), float(focal), scenario)


def _sweep(scenario: Scenario, rng: np.random.Generator, axes: int) -> Floats:
    """Return smooth paths, (steps, axes) from -1 to 1: sums of slow swings."""
    seconds = (np.arange(scenario.steps)[:, None, None] + 0.5) * scenario.period_s
    phase = rng.uniform(0, 2 * np.pi, (axes, len(_SWEEP_S)))
    return np.asarray(np.sin(2 * np.pi * seconds / np.array(_SWEEP_S) + phase) @ np.array(_SHARES))


def _corner_rays(camera: Camera) -> Floats:
    corners = np.array([(0, 0), (1, 0), (0, 1), (1, 1)]) * np.array(camera.size)
    seen = (corners - camera.principal_point) / camera.focal_px
    return np.asarray(np.column_stack([seen, np.ones(4)]) @ camera.rotation)
