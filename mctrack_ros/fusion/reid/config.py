"""Parameters and columns of the identity stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter
from mctrack_ros.fusion.columns import Column, Columns
from mctrack_ros.interfaces import TEMPLATE_SIZE


@dataclass(frozen=True)
class ReidConfig:
    """Who is who after an encounter."""

    contact_distance: float = parameter(
        1.5, 'Who is nearer to another may leave as that one [m]', minimum=0.0, maximum=100.0
    )
    lost_time: float = parameter(
        20.0, 'For how long one who was lost may be found again [s]', minimum=0.0, maximum=10000.0
    )


class IdentityColumns(Columns):
    """
    What the tracks look like.

    Attributes
    ----------
    template : (n, 48) float32 array
        Appearance; zero: unknown.
    look : (n, 48) array
        Sum of the square roots of its templates since its last contact, weighted by time.
    look_s : (n,) array
        The time that this sum covers, of all cameras together, s.
    judge_s : (n,) array
        How long it must be before the identity is judged, s.
    in_contact : (n,) bool array
        Whether it is near another track.
    kit : (n,) uint8 array
        Clothing cluster; 0: unknown.

    """

    __slots__ = ()
    template = Column(np.float32, TEMPLATE_SIZE)
    look = Column(np.float64, TEMPLATE_SIZE)
    look_s = Column(np.float64)
    judge_s = Column(np.float64)
    in_contact = Column(np.bool_)
    kit = Column(np.uint8)

    def absorb(self, kept: int, dropped: int) -> None:
        """Take the template if there is none."""
        if not self.template[kept].any():
            self.template[kept] = self.template[dropped]
