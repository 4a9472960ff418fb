"""What one camera sees at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces.codes import MEMBERS, TEMPLATE_SIZE
from mctrack_ros.interfaces.rows import POSITION, Column, Rows

_VARIANCE = 0.09
"""Of a ground position whose detector does not state it, m²: feet are off by some 0.3 m."""


@dataclass(frozen=True, eq=False, slots=True)
class Detections(Rows):
    """
    Detections of one camera, one row each; an empty one is the camera's heartbeat.

    A lone row without a position, of score 0, that names nobody is blind: the camera cannot tell
    who is there, as while it learns its background.
    A message must have positions and scores alone; what else it lacks has the default of its
    column, a covariance that of 0.3 m along each axis.

    Attributes
    ----------
    position : (n, 3) float32 array
        Foot point on the ground, m, ground frame; NaN where it is not known.
    covariance : (n, 2, 2) float32 array
        Of the ground position, m².
    box : (n, 4) float32 array
        Left, top, width, height, px.
    area : (n,) float32 array
        Foreground area, px².
    score : (n,) float32 array
        Confidence, 0 to 1.
    extent : (n, 2) float32 array
        Width and height of the target, m; NaN where not known.
    template : (n, 48) float32 array
        Appearance histogram, zero where there is none.
    local_id : (n,) uint32 array
        The camera's own track; 0: none.
    track_id : (n,) uint32 array
        Global track that feedback taught the camera; 0: not known.
    members : (n, 16) uint32 array
        Global ids in a group, zero-padded.
    member_count : (n,) uint8 array
        1: a single target, more: a group, 0: a group of unknown size.
    truncated : (n,) uint8 array
        1 where the box touches the image's edge.
    class_id : (n,) uint8 array
        A `ClassCode`.
    kit : (n,) uint8 array
        Cluster of clothing, 0: not known.

    """

    TOPIC: ClassVar[str] = 'detections'
    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': POSITION,
        'covariance': Column('f4', (2, 2), absent=((_VARIANCE, 0.0), (0.0, _VARIANCE))),
        'box': Column('f4', (4,), absent=0.0),
        'area': Column('f4', absent=0.0),
        'score': Column('f4', (), 1.0),
        'extent': Column('f4', (2,), float('nan'), absent=float('nan')),
        'template': Column('f4', (TEMPLATE_SIZE,), absent=0.0),
        'local_id': Column('u4', absent=0),
        'track_id': Column('u4', absent=0),
        'members': Column('u4', (MEMBERS,), absent=0),
        'member_count': Column('u1', (), 1, absent=1),
        'truncated': Column('u1', absent=0),
        'class_id': Column('u1', absent=0),
        'kit': Column('u1', absent=0),
    }

    position: NDArray[np.float32]
    covariance: NDArray[np.float32]
    box: NDArray[np.float32]
    area: NDArray[np.float32]
    score: NDArray[np.float32]
    extent: NDArray[np.float32]
    template: NDArray[np.float32]
    local_id: NDArray[np.uint32]
    track_id: NDArray[np.uint32]
    members: NDArray[np.uint32]
    member_count: NDArray[np.uint8]
    truncated: NDArray[np.uint8]
    class_id: NDArray[np.uint8]
    kit: NDArray[np.uint8]

    @classmethod
    def blind(cls, stamp_ns: int) -> Self:
        """Return the message of a camera that cannot tell who is there."""
        nowhere = np.full((1, 3), np.nan)
        return cls.build(stamp_ns, position=nowhere, score=[0.0], member_count=[0])

    @property
    def is_blind(self) -> bool:
        """Tell whether the camera could not tell who is there."""
        return (
            len(self) == 1
            and bool(self.score[0] == 0.0 and self.track_id[0] == 0)
            and bool(np.isnan(self.position).all())
        )
