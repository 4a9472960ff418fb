"""Parameters and columns of the existence stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter
from mctrack_ros.fusion.columns import Column, Columns


@dataclass(frozen=True)
class ExistenceConfig:
    """What the log-odds of a track count."""

    hit_evidence: float = parameter(
        2.0,
        'What a detection adds to the log-odds of a track, per look',
        minimum=0.0,
        maximum=100.0,
        at_run_time=True,
    )
    confirm_evidence: float = parameter(
        4.0, 'Log-odds that confirm a track', minimum=0.0, maximum=100.0, at_run_time=True
    )
    coverage_prior: float = parameter(
        0.7,
        'Probability that a camera detects what stands where nothing is known yet',
        minimum=0.0,
        maximum=0.99,
    )
    coverage_cell: float = parameter(
        2.0, 'Edge of a cell of the learned coverage [m]', minimum=0.01, maximum=1000.0
    )


class ExistenceColumns(Columns):
    """
    Whether the tracks exist.

    Attributes
    ----------
    confirmed : (n,) bool array
    evidence : (n,) array
        Log-odds of being a target.
    missed : (n,) array
        Log-odds of having gone: no camera detects it though some should.
    shown_by : (n,) uint32 array
        Bits of the cameras whose latest image shows it, alone or in a group.
    pace_s : (n,) array
        Interval of the slowest camera that detected it last, alone or in a group, s; 0: unknown.

    """

    __slots__ = ()
    confirmed = Column(np.bool_)
    evidence = Column(np.float64)
    missed = Column(np.float64)
    shown_by = Column(np.uint32)
    pace_s = Column(np.float64)

    def absorb(self, kept: int, dropped: int) -> None:
        """Take the better evidence."""
        self.evidence[kept] = max(self.evidence[kept], self.evidence[dropped])
        if self.confirmed[dropped]:
            self.missed[kept] = min(self.missed[kept], self.missed[dropped])
        self.shown_by[kept] |= self.shown_by[dropped]
