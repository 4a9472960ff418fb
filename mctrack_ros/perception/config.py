"""What the parameters of every camera tracker share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from mctrack_ros.ground import GroundMapping

FARTHEST_SHARE = 1 / 3
"""Smallest height of a person whom a tracker looks for, as a share of the usual one in its image,
where none is stated. What is smaller is nearly always a piece of somebody nearer: on the street
MODA of single images is -0.25 with, -0.72 without; the smallest people of PETS, the terrace, the
street and the pitch have 0.55 to 0.7 of the usual height."""


@dataclass(frozen=True)
class DetectionLimits:
    """
    How far a tracker sees people, and how precisely, for who reckons what a camera covers.

    Attributes
    ----------
    person_height_m : float
        Height of people, m.
    farthest_height_px : float
        Smallest height of a person, px; what is smaller is too far away. 0: a share of the usual
        height, see `farthest_px`.
    foot_noise_px : float
        Standard deviation of a foot point, the part that is the same for all, px.
    foot_noise_share : float
        The part that grows with the box, as a share of its height.

    """

    person_height_m: float = 1.75
    farthest_height_px: float = 8.0
    foot_noise_px: float = 0.7
    foot_noise_share: float = 0.025

    def farthest_px(self, mapping: GroundMapping) -> float:
        """Return the smallest height of a person in the images of a camera, px."""
        usual = mapping.usual_height_px(self.person_height_m)
        return self.farthest_height_px or FARTHEST_SHARE * usual


@dataclass(frozen=True)
class CameraConfig:
    """
    Parameters of a camera's tracker; each has a subclass of its own.

    Attributes
    ----------
    local_tracker : str
        Which tracker they are of.

    """

    local_tracker: str

    @property
    def limits(self) -> DetectionLimits:
        """How far the tracker sees people, and how precisely."""
        return DetectionLimits()

    @property
    def moves(self) -> bool:
        """Whether the camera pans, tilts and zooms: its calibration is that of one image."""
        return False

    def within(self, area: str) -> Self:
        """Return the parameters for a site whose area has the corners ``x0,y0,x1,y1``, m."""
        return self
