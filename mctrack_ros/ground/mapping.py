"""The seam between pixels and metres: what every kind of calibration can do."""

from __future__ import annotations

from abc import ABC, abstractmethod
from copy import copy
from typing import Self

import numpy as np
from numba import types
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.compiled import FLOATS_3D, compiled, inner

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
SAMPLED_PX = 8
"""Distance of the pixels that stand for an image."""


class GroundMapping(ABC):
    """
    Image <-> ground plane z = 0 of one camera; everything is vectorised.

    Attributes
    ----------
    image_size : (int, int)
        Width and height of the camera's images, px.
    origin : (2,) array
        About which it computes, m; callers see coordinates without it.

    """

    image_size: tuple[int, int]
    origin: Floats = np.zeros(2)

    def moved(self, by: ArrayLike) -> Self:
        """Return the mapping of the same camera where all positions are greater by (2,) m."""
        mapping = copy(self)
        mapping.origin = self.origin + np.asarray(by, np.float64)
        return mapping

    def _local(self, position: ArrayLike) -> Floats:
        """Return the (n, 2) positions, m, about the mapping's origin."""
        local: Floats = points_of(position) - self.origin
        return local

    def _stated(self, place: Floats) -> Floats:
        """Return a place about the origin in the caller's coordinates, (3,) m."""
        stated: Floats = place + np.append(self.origin, 0.0)
        return stated

    @property
    @abstractmethod
    def camera_position(self) -> Floats:
        """Where the camera stands, (3,) m."""

    @abstractmethod
    def ground_from_image(self, pixel: ArrayLike) -> Floats:
        """Return the (n, 2) ground positions, m, of (n, 2) pixels; NaN where there is none."""

    @abstractmethod
    def image_from_ground(self, position: ArrayLike, height: ArrayLike = 0.0) -> Floats:
        """
        Return the (n, 2) pixels of (n, 2) ground positions, m; NaN where there is none.

        Parameters
        ----------
        position : (n, 2) array_like
            Ground positions, m.
        height : array_like
            Height above the ground, m: a number or (n,).

        """

    @abstractmethod
    def image_jacobian(self, position: ArrayLike) -> Floats:
        """Return the (n, 2, 2) derivatives of pixels by ground positions, px/m."""

    def lens_edge(self) -> Floats:
        """Return (n, 2) pixels around all that the lens has a direction for; none: no limit."""
        return np.empty((0, 2))

    def is_extrapolated(self, pixel: ArrayLike) -> Mask:
        """Tell which (n, 2) pixels lie where the calibration is not supported by its points."""
        return np.zeros(len(points_of(pixel)), np.bool_)

    def calibration_covariance(self, position: ArrayLike) -> Floats:
        """
        Return the (n, 2, 2) covariances, m², that the calibration adds at (n, 2) positions, m.

        Zero for a calibration that does not know how good it is; more where `is_extrapolated`.
        """
        return np.zeros((len(points_of(position)), 2, 2))

    def ground_covariance(self, position: ArrayLike, pixel_covariance: ArrayLike) -> Floats:
        """
        Propagate pixel covariance to the ground, to first order, and add the calibration's.

        Parameters
        ----------
        position : (n, 2) array_like
            Ground positions, m.
        pixel_covariance : (n, 2, 2) or (2, 2) array_like
            Covariance in the image, px².

        Returns
        -------
        (n, 2, 2) array
            Covariance on the ground, m².

        """
        spread = self.propagated(position, pixel_covariance)
        return spread + self.calibration_covariance(position)

    def propagated(self, position: ArrayLike, pixel_covariance: ArrayLike) -> Floats:
        """Return the (n, 2, 2) covariances, m², that pixel covariances alone give."""
        noise = np.ascontiguousarray(pixel_covariance, np.float64).reshape(-1, 2, 2)
        return propagated(self.image_jacobian(position), noise)

    def locate(self, pixel: ArrayLike, pixel_covariance: ArrayLike) -> tuple[Floats, Floats]:
        """
        Return (n, 2) positions, m, and their (n, 2, 2) covariances, m².

        Parameters
        ----------
        pixel : (n, 2) array_like
            Pixels.
        pixel_covariance : (n, 2, 2) or (2, 2) array_like
            How well they are known, px².

        """
        position = self.ground_from_image(pixel)
        return position, self.ground_covariance(position, pixel_covariance)

    def image_covariance(self, position: ArrayLike, ground_covariance: ArrayLike) -> Floats:
        """
        Propagate ground covariance into the image, to first order.

        Parameters
        ----------
        position : (n, 2) array_like
            Ground positions, m.
        ground_covariance : (n, 2, 2) or (2, 2) array_like
            Covariance on the ground, m².

        Returns
        -------
        (n, 2, 2) array
            Covariance in the image, px².

        """
        jacobian = self.image_jacobian(position)
        covariance: Floats = (
            jacobian @ np.asarray(ground_covariance, np.float64) @ jacobian.swapaxes(1, 2)
        )
        return covariance

    def visible_ground(self) -> Floats:
        """Return the (n, 2) ground positions, m, of pixels all over the image that show ground."""
        width, height = self.image_size
        column, row = np.meshgrid(
            np.arange(0, width, SAMPLED_PX), np.arange(0, height, SAMPLED_PX)
        )
        position = self.ground_from_image(np.column_stack([column.ravel(), row.ravel()]))
        return np.asarray(position[np.isfinite(position).all(axis=1)])

    def height_px(self, position: ArrayLike, height: float) -> Floats:
        """Return how many rows, (n,) px, something of that height (m) spans at (n, 2) places."""
        foot = self.image_from_ground(position)
        head = self.image_from_ground(position, height)
        rows: Floats = foot[:, 1] - head[:, 1]
        return rows

    def usual_height_px(self, height: float) -> float:
        """Return how many rows, px, something of that height (m) spans: the median of the image.

        0 where the image shows no ground.
        """
        position = self.visible_ground()
        return float(np.median(self.height_px(position, height))) if len(position) else 0.0

    def height_doubt(self, height: float) -> float:
        """
        Return how well the pose tells how many rows a height, m, spans: relative deviation.

        0: the pose is known; infinite: nothing tells.
        """
        return 0.0

    def width_px(self, position: ArrayLike, width: float) -> Floats:
        """Return how many columns, (n,) px, something of that width (m) spans at (n, 2) places."""
        jacobian = self.image_jacobian(position)
        columns: Floats = width * np.hypot(jacobian[:, 0, 0], jacobian[:, 0, 1])
        return columns


@inner
def solve_spread(
    xx: float, xy: float, yx: float, yy: float, noise: Floats, spread: Floats
) -> None:
    """Write the inverse of ((xx, xy), (yx, yy)), a jacobian, about a (2, 2) covariance."""
    scale = xx * yy - xy * yx
    if scale == 0.0:
        spread[:] = np.nan
        return
    a, b, c, d = yy / scale, -xy / scale, -yx / scale, xx / scale
    mixed = (noise[0, 1] + noise[1, 0]) / 2.0
    spread[0, 0] = a * a * noise[0, 0] + 2.0 * a * b * mixed + b * b * noise[1, 1]
    spread[1, 1] = c * c * noise[0, 0] + 2.0 * c * d * mixed + d * d * noise[1, 1]
    spread[0, 1] = a * c * noise[0, 0] + (a * d + b * c) * mixed + b * d * noise[1, 1]
    spread[1, 0] = spread[0, 1]


@compiled(types.f8[:, :, ::1](FLOATS_3D, FLOATS_3D))
def propagated(jacobian: Floats, noise: Floats) -> Floats:
    """Return (n, 2, 2) ground covariances from those in the image, one for all or one each."""
    spread = np.empty((len(jacobian), 2, 2))
    for index in range(len(jacobian)):
        slope = jacobian[index]
        solve_spread(
            slope[0, 0], slope[0, 1], slope[1, 0], slope[1, 1],
            noise[index if len(noise) > 1 else 0], spread[index],
        )  # fmt: skip
    return spread


def points_of(values: ArrayLike) -> Floats:
    """
    Return (n, 2) points as the compiled functions take them; one point, (2,), is taken for one.

    Raises
    ------
    ValueError
        If the last axis is not of two.

    """
    points = np.ascontiguousarray(values, np.float64)
    if points.size and points.shape[-1:] != (2,):
        raise ValueError(f'points have shape {points.shape}, expected (n, 2)')
    return points.reshape(-1, 2)
