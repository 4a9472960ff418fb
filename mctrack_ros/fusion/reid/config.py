"""Parameters and columns of the identity stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter
from mctrack_ros.fusion.columns import Column, Columns
from mctrack_ros.interfaces import TEMPLATE_SIZE


@dataclass(frozen=True)
class ReidConfig:
    """Parameters of re-identification after an encounter."""

    contact_distance: float = parameter(
        1.5,
        'Tracks nearer than this may change their ids [m]',
        minimum=0.0,
        maximum=100.0,
        at_run_time=True,
    )
    lost_time: float = parameter(
        20.0,
        'For how long one who was lost may be found again [s]',
        minimum=0.0,
        maximum=10000.0,
        at_run_time=True,
    )


class IdentityColumns(Columns):
    """
    Appearance of the targets.

    Attributes
    ----------
    template : (n, 48) float32 array
        Colours of the track's detections of late; zero: none.
    gallery, gallery_s : (n, 48), (n,) arrays
        Mean square root of the templates of its target, while that was surely itself, and the
        time of that, all cameras together, s; 0: no gallery.
    sample, sample_s : (n, 48), (n,) arrays
        Sum of the square roots of templates that the gallery does not have yet, and its time, s.
    judge_s : (n,) array
        Time of a sample at which identity is judged, s.
    in_contact : (n,) bool array
        Whether another track is near.
    contact_ns, contact_place : (n,), (n, 2) arrays
        When and where, m, another track was near last: there its target may have left it.
    kit : (n,) uint8 array
        Clothing cluster; 0: unknown.

    """

    __slots__ = ()
    template = Column(np.float32, TEMPLATE_SIZE)
    gallery = Column(np.float64, TEMPLATE_SIZE)
    gallery_s = Column(np.float64)
    sample = Column(np.float64, TEMPLATE_SIZE)
    sample_s = Column(np.float64)
    judge_s = Column(np.float64)
    in_contact = Column(np.bool_)
    contact_ns = Column(np.int64)
    contact_place = Column(np.float64, 2)
    kit = Column(np.uint8)

    def absorb(self, kept: int, dropped: int) -> None:
        """Take the template if there is none."""
        if not self.template[kept].any():
            self.template[kept] = self.template[dropped]
