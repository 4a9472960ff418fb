"""The project's own fusion as the benchmark drives trackers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion import JointConfig, JointTracker
from mctrack_ros.fusion.association.config import JointAssociationConfig
from mctrack_ros.fusion.motion.config import InteractingConfig
from mctrack_ros.interfaces import REPORTED, CameraDetections, Detections, Tick, Tracks

Reported = tuple[list[int], NDArray[np.float64]]

IS_REPORTED = np.isin(np.arange(256), REPORTED)
"""By status."""

SENSOR_SIGMA_M = 0.001
"""The covariances of the scenes are true: cameras there have no errors beside them, m."""

MOTION: dict[str, Any] = {
    'calm_density': 0.05,
    'manoeuvre_density': 3.0,
    'calm_time': 3.0,
    'manoeuvre_time': 1.0,
    'acceleration_density': 1.5,
}
"""Of the targets, m²/s³ and s."""


class CoreTracker:
    """
    The core tick: positions and covariances in, tracks out, nothing else known.

    Parameters
    ----------
    scenario : Scenario of the benchmark
        Its detections and what is told about its cameras.

    """

    def __init__(self, scenario: Any) -> None:
        self._scenario = scenario
        self._pipeline = JointTracker(told_config(scenario), camera_names(scenario))

    def prepare(self, frame: int) -> None:
        """Bring a tick's detections into the project's types; not timed."""
        self._tick = Tick.of(messages_of(self._scenario, frame))

    def step(self, frame: int) -> Reported:
        """Process the tick."""
        return reported(self._pipeline.step(self._tick).tracks)


def camera_names(scenario: Any) -> tuple[str, ...]:
    """Return names whose order is that of the scene's cameras."""
    return tuple(f'cam{index:02}' for index in range(scenario.cameras))


def messages_of(scenario: Any, frame: int) -> list[CameraDetections]:
    """Return what the cameras detect at a tick: places and how sure they are."""
    detections, stamp_ns = scenario.detections(frame), stamp_of(scenario, frame)
    messages = []
    for index, camera in enumerate(camera_names(scenario)):
        position, covariance = detections.of_camera(index)
        rows = Detections.build(stamp_ns, position=on_ground(position), covariance=covariance)
        messages.append(CameraDetections(camera, rows))
    return messages


def told_config(scenario: Any) -> JointConfig:
    """
    Return what the benchmark tells every tracker, and what was tuned on its seeds 1 to 3.

    Tuned are the associator and the motion; all else is as it comes.
    """
    default = JointConfig()
    density = scenario.sensors.clutter_density
    return replace(
        default,
        batching=replace(default.batching, period=scenario.tick_s),
        motion=InteractingConfig(sensor_sigma=SENSOR_SIGMA_M, **MOTION),
        association=JointAssociationConfig(method='jpda', false_density=density),
    )


def stamp_of(scenario: Any, frame: int) -> int:
    """Return the stamp of a tick, ns."""
    return round((frame + 1) * float(scenario.tick_s) * 1e9)


def on_ground(position: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (n, 2) ground positions with their height, (n, 3), m."""
    return np.column_stack([position, np.zeros(len(position))])


def reported(tracks: Tracks) -> Reported:
    """Return ids and (n, 2) positions, m, of the tracks that fusion stands for."""
    shown = IS_REPORTED[tracks.status]
    return tracks.track_id[shown].tolist(), tracks.position[shown, :2].astype(np.float64)
