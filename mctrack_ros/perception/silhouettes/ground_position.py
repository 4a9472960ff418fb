"""Where objects stand on the ground, and how large they are there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter
from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.geometry.ground_extent import depth_covariance, ground_depth
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.silhouettes.features import Floats, Mask


@dataclass(frozen=True)
class PlaceConfig:
    """Parameters of `Places`."""

    foot_noise_px: float = parameter(
        1.5, 'standard deviation of the foot point, constant part [px]',
        minimum=0.01,
    )  # fmt: skip
    foot_noise_share: float = parameter(
        0.04, 'part that grows with the box, as a share of its height', minimum=0.0
    )


class Places:
    """
    Ground positions of boxes.

    Parameters
    ----------
    config : PlaceConfig
        Parameters.
    vehicle_height_m : float
        Height of vehicles, m.
    mapping : GroundMapping
        Of the camera.

    """

    def __init__(
        self, config: PlaceConfig, vehicle_height_m: float, mapping: GroundMapping
    ) -> None:
        self._config, self._mapping = config, mapping
        self._vehicle_height_m = vehicle_height_m
        self.sizes = SizeTable(mapping)

    def extent(self, box: Floats) -> Floats:
        """Return (n, 2) widths and heights, m, of (n, 4) boxes, px, taken for upright."""
        return np.asarray(box[:, 2:] / self.sizes.per_metre(self.sizes.foot_of(box)))

    def locate(self, box: Floats, vehicle: Mask, shift_px: float = 0.0) -> tuple[Floats, Floats]:
        """
        Return where boxes stand.

        A person stands at the bottom centre of the box, a vehicle in the middle of the ground
        that it covers.

        Parameters
        ----------
        box : (n, 4) array
            Boxes, px.
        vehicle : (n,) bool array
            Which are vehicles'.
        shift_px : float
            How far the camera has moved, px: that much less certain is the foot.

        Returns
        -------
        position : (n, 2) array
            Ground positions, m; NaN above the horizon.
        covariance : (n, 2, 2) array
            Theirs, m².

        """
        near = self._mapping.ground_from_image(self.sizes.foot_of(box))
        depth = ground_depth(box, self._vehicle_height_m, self.sizes, self._mapping)
        depth[~vehicle] = 0.0
        position = near + depth / 2
        deviation = self._config.foot_noise_px + self._config.foot_noise_share * box[:, 3]
        noise = (deviation**2 + shift_px**2)[:, None, None] * np.eye(2)
        covariance = self._mapping.ground_covariance(position, noise)
        return position, covariance + depth_covariance(depth)
