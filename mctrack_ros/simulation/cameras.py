"""Static cameras: a pinhole with radial lens distortion, and the five of ``pitch5``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.simulation.pitch.field import LENGTH_M, WIDTH_M
from mctrack_ros.simulation.scenario import Scenario

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class Camera:
    """
    A camera; pixel (0, 0) is the image's corner, pixel centres lie at halves.

    Attributes
    ----------
    name : str
        Its name, also that of its topics.
    position : (3,) array
        Where it stands, m.
    rotation : (3, 3) array
        From the world to the camera's right, down and forward.
    focal_px : float
        Focal length, px.
    size : (int, int)
        Width and height of the image, px; the principal point is its centre.
    distortion : float
        First radial coefficient on normalised coordinates: ``r (1 + distortion r²)``.

    """

    name: str
    position: Floats
    rotation: Floats
    focal_px: float
    size: tuple[int, int]
    distortion: float = 0.0

    @property
    def mosaic(self) -> Camera:
        """Return the camera of an image of all that is ever seen: itself."""
        return self

    def at(self, step: int) -> Camera:
        """Return the camera at a step: itself."""
        return self

    @property
    def principal_point(self) -> Floats:
        """Return the image's centre, (2,) px."""
        return np.array(self.size) / 2

    @property
    def matrix(self) -> Floats:
        """Return the (3, 4) projection of homogeneous world coordinates, m, without distortion."""
        lens = np.diag([self.focal_px, self.focal_px, 1.0])
        lens[:2, 2] = self.principal_point
        moved = np.column_stack([np.eye(3), -self.position])
        return np.asarray(lens @ self.rotation @ moved)

    def depth(self, world: ArrayLike) -> Floats:
        """Return how far in front of the camera (..., 3) points are, (...) m."""
        return np.asarray((np.asarray(world, np.float64) - self.position) @ self.rotation[2])

    def project(self, world: ArrayLike) -> Floats:
        """Return the (..., 2) pixels of (..., 3) world points in front of the camera, m."""
        local = (np.asarray(world, np.float64) - self.position) @ self.rotation.T
        normalised = local[..., :2] / np.maximum(local[..., 2:], 1e-3)
        if self.distortion:
            square = (normalised**2).sum(axis=-1, keepdims=True)
            normalised = normalised * (1 + self.distortion * square)
        return np.asarray(normalised * self.focal_px + self.principal_point)

    def ground(self, pixel: ArrayLike) -> Floats:
        """Return the (..., 2) places on the ground, m, of (..., 2) pixels; NaN in the sky."""
        seen = (np.asarray(pixel, np.float64) - self.principal_point) / self.focal_px
        normalised = self.undistorted(seen)
        ray = normalised @ self.rotation[:2] + self.rotation[2]
        falling = ray[..., 2:] < -1e-9
        scale = self.position[2] / np.where(falling, -ray[..., 2:], 1)
        return np.where(falling, self.position[:2] + scale * ray[..., :2], np.nan)

    def warp_from(self, other: Camera) -> Floats:
        """
        Return the (3, 3) homography from another camera's image at the same place.

        Pixel centres lie at whole numbers in it, as OpenCV has them.
        """
        before, after = np.eye(3), np.eye(3)
        before[:2, 2], after[:2, 2] = 0.5 - other.principal_point, self.principal_point - 0.5
        scales = (1 / other.focal_px, 1 / other.focal_px, 1), (self.focal_px, self.focal_px, 1)
        turned = self.rotation @ other.rotation.T
        return np.asarray(after @ np.diag(scales[1]) @ turned @ np.diag(scales[0]) @ before)

    def sees(self, world: ArrayLike) -> NDArray[np.bool_]:
        """Return which of (..., 3) world points fall into the image."""
        pixel = self.project(world)
        inside = ((pixel >= 0) & (pixel < np.array(self.size))).all(axis=-1)
        return np.asarray(inside & (self.depth(world) > 1))

    def undistorted(self, seen: Floats) -> Floats:
        """Invert the distortion of (..., 2) normalised coordinates by fixed-point iteration."""
        normalised = seen
        if self.distortion:
            for _ in range(20):
                square = (normalised**2).sum(axis=-1, keepdims=True)
                normalised = seen / (1 + self.distortion * square)
        return normalised


def looking_at(
    name: str, position: ArrayLike, target: ArrayLike, focal_px: float, scenario: Scenario
) -> Camera:
    """Return an upright camera at a (3,) position that looks at a (3,) target, m."""
    place, aim = np.asarray(position, np.float64), np.asarray(target, np.float64)
    forward = (aim - place) / np.linalg.norm(aim - place)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    size = (scenario.width, scenario.height)
    return Camera(
        name, place, rotation, focal_px * scenario.width / 768, size, scenario.distortion
    )


def pitch5_cameras(scenario: Scenario) -> tuple[Camera, ...]:
    """
    Return the cameras of ``pitch5``: five, near-orthogonal over the penalty areas, or the first.

    Four stand behind the corners of a stadium and look across the near half of the pitch, the
    fifth behind the southern touch line (event-tracking paper, section 3.1 and Figure 19).
    """
    cameras = []
    places = {'cam1': (-1, -1), 'cam2': (-1, 1), 'cam3': (1, -1), 'cam4': (1, 1)}
    for name, (east, north) in places.items():
        mirrored_x, mirrored_y = (LENGTH_M if east > 0 else 0.0), (WIDTH_M if north > 0 else 0.0)
        position = (mirrored_x + east * 36.5, mirrored_y + north * 35.1, 15.0)
        target = (mirrored_x - east * 15.0, mirrored_y - north * 31.6, 0.0)
        cameras.append(looking_at(name, position, target, 1500, scenario))
    middle = LENGTH_M / 2
    position, target = (middle, -37.7, 17.0), (middle, 20.0, 0.0)
    cameras.append(looking_at('cam5', position, target, 1500, scenario))
    return tuple(cameras[: scenario.cameras])
