"""Parameters of the joint tracker; columns of its output."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter, tag
from mctrack_ros.fusion.association.config import ASSOCIATION, AssociationConfig
from mctrack_ros.fusion.columns import Column, Columns
from mctrack_ros.fusion.config import FusionConfig
from mctrack_ros.fusion.management.config import ManagementConfig
from mctrack_ros.fusion.motion.config import MOTION, MotionConfig
from mctrack_ros.fusion.reid.config import ReidConfig


@dataclass(frozen=True)
class JointConfig(FusionConfig):
    """Parameters of `JointTracker`."""

    tracker: str = tag('joint')
    untrusted: str = parameter(
        '',
        'Cameras, separated by commas, whose detections start no track; they support those that '
        'others started; joint alone takes it',
    )
    motion: MotionConfig = MOTION.field()
    association: AssociationConfig = ASSOCIATION.field()
    management: ManagementConfig = ManagementConfig()
    reid: ReidConfig = ReidConfig()


class OutputColumns(Columns):
    """
    What is published and decides nothing.

    Attributes
    ----------
    extent : (n, 2) float32 array
        Width and height, m; NaN: unknown.
    class_id : (n,) uint8 array
    class_lead_s : (n,) array
        How much longer than all others its class was detected, in all cameras, s.

    """

    __slots__ = ()
    extent = Column(np.float32, 2, fill=np.nan)
    class_id = Column(np.uint8)
    class_lead_s = Column(np.float64)

    def absorb(self, kept: int, dropped: int) -> None:
        """Take the extent where there is none."""
        own = self.extent[kept]
        self.extent[kept] = np.where(np.isnan(own), self.extent[dropped], own)
