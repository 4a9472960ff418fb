"""What one camera contributes to a coverage: the ground that it sees, and how well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.coverage.field_of_view import Region
from mctrack_ros.ground.mapping import GroundMapping

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """
    What one camera contributes.

    Attributes
    ----------
    field : Polygon or MultiPolygon
        The ground that it sees, m.
    mapping : GroundMapping or None
        How well it measures; None if that is not known: it then has no predicted error.
    foot_noise_px, foot_noise_share : float
        Standard deviation of a foot point: what is the same for all, px, and what grows with
        the person's height in the image, as a share of it.
    person_height : float
        Height of a person, m.

    """

    field: Region
    mapping: GroundMapping | None = None
    foot_noise_px: float = 0.7
    foot_noise_share: float = 0.025
    person_height: float = 1.75

    @property
    def foot(self) -> Floats:
        """Where the camera stands, (2,) m; NaN if that is not known."""
        return np.full(2, np.nan) if self.mapping is None else self.mapping.camera_position[:2]

    def covariance(self, position: Floats) -> Floats:
        """Return (n, 2, 2) covariances, m², of people's (n, 2) positions; NaN if not known."""
        if self.mapping is None:
            return np.full((len(position), 2, 2), np.nan)
        tallest = float(self.mapping.image_size[1])
        rows = self.mapping.height_px(position, self.person_height)
        rows = np.clip(np.nan_to_num(rows, nan=tallest), 0.0, tallest)
        deviation = self.foot_noise_px + self.foot_noise_share * rows
        return self.mapping.ground_covariance(position, deviation[:, None, None] ** 2 * np.eye(2))
