"""Parameters and columns of the association stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import OneOf, parameter, tag
from mctrack_ros.fusion.association.solvers import ASSOCIATORS
from mctrack_ros.fusion.columns import NEVER_NS, PER_CAMERA, Column, Columns


@dataclass(frozen=True)
class AssociationConfig:
    """
    Which detection belongs to which track; the methods have subclasses of their own.

    Attributes
    ----------
    method : str
        Which method it is of.

    """

    method: str
    gate: float = parameter(
        13.8,
        'Largest squared Mahalanobis distance of a pair',
        minimum=0.1,
        maximum=1000.0,
        at_run_time=True,
    )
    appearance_weight: float = parameter(
        24.0,
        'What the squared Hellinger distance of two templates costs, beyond the usual [-2 log]',
        minimum=0.0,
        maximum=1000.0,
        at_run_time=True,
    )
    usual_difference: float = parameter(
        0.15,
        'Squared Hellinger distance of two templates that speaks neither for nor against',
        minimum=0.0,
        maximum=1.0,
        at_run_time=True,
    )


@dataclass(frozen=True)
class JointAssociationConfig(AssociationConfig):
    """Parameters of `JointAssociation`."""

    method: str = tag(*(name for name in ASSOCIATORS if name != 'covering_graph'))
    false_density: float = parameter(
        0.01,
        'Detections that belong to no known target, per camera and image; of those of a '
        "camera's own tracker, with a `local_id`, a fifth [1/m^2]",
        minimum=1e-9,
        maximum=100.0,
        at_run_time=True,
    )


@dataclass(frozen=True)
class CoveringConfig(AssociationConfig):
    """Parameters of `CoveringAssociation`."""

    method: str = tag('covering_graph')


ASSOCIATION: OneOf[AssociationConfig] = OneOf(
    'method',
    'weighed_gnn',
    'How pairs compete',
    {
        name: CoveringConfig if name == 'covering_graph' else JointAssociationConfig
        for name in ASSOCIATORS
    },
)
"""The choice of how pairs compete."""


class AssociationColumns(Columns):
    """
    Which cameras detected the tracks.

    Attributes
    ----------
    cameras : (n,) uint32 array
        Bits of the cameras that detected it this tick.
    seen_ns : (n,) int64 array
        Stamp of the last detection of its own.
    kept_ns : (n,) int64 array
        Stamp of the last detection of its own or of its group.
    seen_by_ns : (n, cameras) int64 array
        Stamp of the last detection of its own, by camera.
    hidden_ns : (n, cameras) int64 array
        Stamp of the last detection of its group, by camera.
    group : (n,) uint32 array
        Smallest id of the group that it is in; 0: none.
    group_ns : (n,) int64 array
        Stamp of the last detection of that group.

    """

    __slots__ = ()
    cameras = Column(np.uint32)
    group = Column(np.uint32)
    seen_ns = Column(np.int64)
    kept_ns = Column(np.int64)
    group_ns = Column(np.int64, fill=NEVER_NS)
    seen_by_ns = Column(np.int64, PER_CAMERA, fill=NEVER_NS)
    hidden_ns = Column(np.int64, PER_CAMERA, fill=NEVER_NS)

    def absorb(self, kept: int, dropped: int) -> None:
        """Take the later detections."""
        for column in (self.seen_ns, self.kept_ns, self.seen_by_ns):
            column[kept] = np.maximum(column[kept], column[dropped])
        self.cameras[kept] |= self.cameras[dropped]
