"""A camera that turns and zooms about a fixed centre: four numbers and their covariance."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground.homography.projective import ProjectiveMapping

Floats = NDArray[np.float64]

_ROUNDS = 5  # of Gauss-Newton
_HUBER = 2.0  # standard deviations from which a measurement counts linearly


@dataclass(frozen=True, eq=False, slots=True)
class TurningCamera:
    """
    A pinhole with square pixels whose principal point is the image's centre.

    Attributes
    ----------
    position : (3,) array
        Its centre, m.
    rotation : (3, 3) array
        From the world to the camera's right, down and forward.
    focal_px : float
        Focal length, px.
    size : (int, int)
        Width and height of the image, px; pixel (0, 0) is the image's corner.
    covariance : (4, 4) array
        Of turns about right, down and forward, rad, and of the logarithm of the focal length.

    """

    position: Floats
    rotation: Floats
    focal_px: float
    size: tuple[int, int]
    covariance: Floats

    @classmethod
    def of(cls, mapping: ProjectiveMapping, turn_rad: float, zoom: float) -> TurningCamera:
        """Return the camera of a calibration, given its standard deviations along the state."""
        width, height = mapping.image_size
        to_centre = np.array([[1.0, 0, -width / 2], [0, 1.0, -height / 2], [0, 0, 1.0]])
        seen = to_centre @ mapping.image_from_world[:, :3]
        seen = seen / np.linalg.norm(seen[2])
        focal = float(np.linalg.norm(seen[:2]) / np.sqrt(2))
        left, _, right = np.linalg.svd(seen / np.array([[focal], [focal], [1.0]]))
        spread = np.diag([turn_rad, turn_rad, turn_rad, zoom]) ** 2
        return cls(mapping.camera_position, left @ right, focal, mapping.image_size, spread)

    def mapping(self) -> ProjectiveMapping:
        """Return image <-> ground as all of the tracker takes it, with its uncertainty."""
        return _TurnedMapping(self)

    def projection(self) -> Floats:
        """Return the (3, 4) projection of homogeneous world coordinates, m, to pixels."""
        lens = np.diag([self.focal_px, self.focal_px, 1.0])
        lens[:2, 2] = np.array(self.size) / 2
        moved = np.column_stack([np.eye(3), -self.position])
        return np.asarray(lens @ self.rotation @ moved)

    def rays(self, pixel: Floats) -> Floats:
        """Return the (n, 3) directions in the world of (n, 2) pixels."""
        seen = (pixel - np.array(self.size) / 2) / self.focal_px
        return np.asarray(np.column_stack([seen, np.ones(len(seen))]) @ self.rotation)

    def project(self, rays: Floats) -> Floats:
        """Return the (n, 2) pixels of (n, 3) directions in the world; NaN behind the camera."""
        local = rays @ self.rotation.T
        ahead = np.where(local[:, 2:] > 1e-6, local[:, 2:], np.nan)
        return np.asarray(local[:, :2] / ahead * self.focal_px + np.array(self.size) / 2)

    def slopes(self, pixel: Floats) -> Floats:
        """Return how (n, 2) pixels move with the state, (n, 2, 4)."""
        u, v = ((pixel - np.array(self.size) / 2) / self.focal_px).T
        rows = [[-u * v, 1 + u**2, -v, u], [-1 - v**2, u * v, u, v]]
        return np.moveaxis(np.array(rows), -1, 0) * self.focal_px

    def grown(self, turn_rad: float, zoom: float) -> TurningCamera:
        """Return it less certain by standard deviations of turn and of the focal length."""
        spread = np.diag([turn_rad, turn_rad, turn_rad, zoom]) ** 2
        return replace(self, covariance=self.covariance + spread)

    def moved(self, change: Floats) -> TurningCamera:
        """Return it after a (4,) change of the state."""
        turn = np.asarray(cv2.Rodrigues(change[:3])[0])
        focal = self.focal_px * float(np.exp(change[3]))
        return replace(self, rotation=turn @ self.rotation, focal_px=focal)

    def carried(self, before: TurningCamera, after: TurningCamera) -> TurningCamera:
        """
        Return it as corrected as another, whose motion relative to it is known.

        Parameters
        ----------
        before, after : TurningCamera
            The other, before and after its correction; its covariance after it is taken over.

        """
        turn = np.eye(4)
        turn[:3, :3] = self.rotation @ before.rotation.T
        return replace(
            self,
            rotation=turn[:3, :3] @ after.rotation,
            focal_px=self.focal_px * after.focal_px / before.focal_px,
            covariance=turn @ after.covariance @ turn.T,
        )

    def updated(
        self, rays: Floats, pixel: Floats, normal: Floats | None, noise_px: float
    ) -> TurningCamera:
        """
        Return the camera after measurements: the iterated extended Kalman filter, robust (Huber).

        Parameters
        ----------
        rays : (n, 3) array
            Directions in the world.
        pixel : (n, 2) array
            Where they are seen.
        normal : (n, 2) array, optional
            The only direction in which that is known, in the image; unless given, both are.
        noise_px : float
            Standard deviation along an axis, px.

        """
        prior = np.linalg.inv(self.covariance)
        offset, camera, information = np.zeros(4), self, prior
        for _ in range(_ROUNDS):
            expected = camera.project(rays)
            missed, slopes = pixel - expected, camera.slopes(expected)
            if normal is not None:
                missed = (missed * normal).sum(axis=1, keepdims=True)
                slopes = np.einsum('ni,nij->nj', normal, slopes)[:, None]
            size = np.linalg.norm(missed, axis=1) / noise_px
            weight = np.where(size < _HUBER, 1, _HUBER / np.maximum(size, 1e-9)) / noise_px**2
            information = prior + np.einsum('n,nik,nil->kl', weight, slopes, slopes)
            pull = np.einsum('n,nik,ni->k', weight, slopes, missed) - prior @ offset
            offset = offset + np.linalg.solve(information, pull)
            camera = self.moved(offset)
        return replace(camera, covariance=np.linalg.inv(information))


class _TurnedMapping(ProjectiveMapping):
    """Image <-> ground of a turning camera; its state's covariance is carried along."""

    def __init__(self, camera: TurningCamera) -> None:
        super().__init__(camera.projection(), camera.size)
        self._camera = camera

    def calibration_covariance(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) covariances, m², that turns and focal length add at positions."""
        slopes = self._camera.slopes(self.image_from_ground(position))
        image = np.einsum('nik,kl,njl->nij', slopes, self._camera.covariance, slopes)
        return self.propagated(position, image)
