"""What the parameters of every camera tracker share."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Sight:
    """
    How far a tracker sees people, and how precisely, for who reckons what a camera covers.

    Attributes
    ----------
    person_height_m : float
        Height of people, m.
    farthest_height_px : float
        Smallest height of a person, px; what is smaller is too far away.
    foot_noise_px : float
        Standard deviation of a foot point, the part that is the same for all, px.
    foot_noise_share : float
        The part that grows with the box, as a share of its height.

    """

    person_height_m: float = 1.75
    farthest_height_px: float = 8.0
    foot_noise_px: float = 0.7
    foot_noise_share: float = 0.025


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
    def sight(self) -> Sight:
        """How far the tracker sees people, and how precisely."""
        return Sight()
