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

GAP_EVERY_S = 10.0
"""From one time in which nobody looks to the next, s."""


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
        By camera, one for each instant that was seen; stamped with the middle of its period.
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
        names = tuple(cameras)
        for images in zip(*(self.detections[name] for name in names), strict=True):
            yield Tick.of(map(CameraDetections, names, images))


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


def blinded(scene: StoredScene, gap_s: float, begin_s: float) -> StoredScene:
    """
    Take out all that was seen in a time, again and again, and the truth of that time.

    Parameters
    ----------
    scene : StoredScene
        As it is.
    gap_s : float
        How long nobody looks each time, s.
    begin_s : float
        When nobody looks for the first time, after the scene's start, s; then every 10 s.

    """
    after_s = np.arange(len(scene.frame)) / scene.rate - begin_s
    is_seen = (after_s < 0) | (after_s % GAP_EVERY_S >= gap_s)
    seen = np.flatnonzero(is_seen)
    detections = {camera: [rows[i] for i in seen] for camera, rows in scene.detections.items()}
    return replace(scene, detections=detections, truth=scene.truth.at_frames(scene.frame[is_seen]))


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
