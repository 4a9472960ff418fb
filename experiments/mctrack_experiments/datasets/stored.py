"""A scene of stored detections: what several real cameras saw, and who was there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation import Trajectories
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import CameraDetections, ClassCode, Detections, Tick

Floats = NDArray[np.float64]
Area = tuple[tuple[float, float], tuple[float, float]]
"""The least and the largest x, and the same of y, m."""


@dataclass(frozen=True, eq=False, slots=True)
class StoredScene:
    """
    Detections of several cameras, image by image.

    Attributes
    ----------
    frame : (n,) int array
        Numbers of the instants as the truth counts them, ascending.
    rate : float
        Instants a second.
    detections : dict of str to list of Detections
        By camera, one for each instant; stamped with the middle of its period.
    truth : Trajectories
        Only for the evaluation.

    """

    frame: NDArray[np.int64]
    rate: float
    detections: dict[str, list[Detections]]
    truth: Trajectories

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of the cameras."""
        return tuple(self.detections)

    def ticks(self, cameras: Iterable[str]) -> Iterator[Tick]:
        """Yield what fusion is given of some cameras, instant by instant."""
        for index in range(len(self.frame)):
            yield Tick.of(CameraDetections(name, self.detections[name][index]) for name in cameras)


def inside(position: Floats, area: Area) -> NDArray[np.bool_]:
    """Tell which ground positions, (n, 2) m, lie in an area."""
    (left, right), (low, high) = area
    x, y = position[:, 0], position[:, 1]
    within: NDArray[np.bool_] = (x >= left) & (x <= right) & (y >= low) & (y <= high)
    return within


def cut_to(detections: Detections, area: Area) -> Detections:
    """Return the detections that lie in an area."""
    return detections.select(inside(detections.position[:, :2].astype(np.float64), area))


def disturbed(scene: StoredScene, sigma: float, seed: int) -> StoredScene:
    """
    Move every detection a little, at random: how a tracker does then tells luck from skill.

    Parameters
    ----------
    scene : StoredScene
        As it is.
    sigma : float
        Standard deviation along each axis, m.
    seed : int
        Of the random numbers.

    """
    random = np.random.default_rng(seed)

    def moved(detections: Detections) -> Detections:
        position = detections.position.copy()
        position[:, :2] += random.normal(0.0, sigma, (len(position), 2))
        return detections.replace(position=position)

    moved_all = {camera: [moved(one) for one in rows] for camera, rows in scene.detections.items()}
    return replace(scene, detections=moved_all)


def stamp_of(index: int, rate: float) -> int:
    """Return the middle of a period, ns, after the first period's start."""
    return round((index + 0.5) / rate * 1e9)


def feet_to_detections(
    feet: Floats,
    mapping: GroundMapping,
    stamp_ns: int,
    foot_sigma_px: float,
    score: Floats | None = None,
    height: float = 0.0,
) -> Detections:
    """
    Put foot points on the ground.

    Parameters
    ----------
    feet : (n, 2) array
        Pixels.
    mapping : GroundMapping
        Of the camera.
    stamp_ns : int
        When the image was taken.
    foot_sigma_px : float
        Standard deviation of a foot point in the image, px.
    score : (n,) array, optional
        Confidence, 0 to 1.
    height : float
        How high above the ground the points are, m.

    """
    ground, camera = mapping.ground_from_image(feet), mapping.camera_position
    ground -= (ground - camera[:2]) * (height / camera[2])  # where the rays are so high
    covariance = mapping.ground_covariance(ground, foot_sigma_px**2 * np.eye(2))
    return Detections.build(
        stamp_ns,
        position=np.column_stack([ground, np.zeros(len(ground))]),
        covariance=covariance,
        score=np.ones(len(ground)) if score is None else score,
        class_id=np.full(len(ground), ClassCode.PERSON),
    )
