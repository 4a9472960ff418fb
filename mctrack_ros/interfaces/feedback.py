"""Feedback: the fusion node's predictions for the cameras."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces.codes import TEMPLATE_SIZE
from mctrack_ros.interfaces.rows import POSITION, Column, Rows


@dataclass(frozen=True, eq=False, slots=True)
class Feedback(Rows):
    """
    Targets as the fusion node believes them to be at the tick's stamp, one row each.

    Attributes
    ----------
    position : (n, 3) float32 array
        Ground position, m.
    velocity : (n, 2) float32 array
        Ground velocity, m/s.
    covariance : (n, 4, 4) float32 array
        Of (x, y, vx, vy), SI units.
    extent : (n, 2) float32 array
        Width and height of the target, m; NaN where not known.
    template : (n, 48) float32 array
        Appearance histogram, zero where there is none.
    track_id : (n,) uint32 array
        Global id.
    previous_id : (n,) uint32 array
        What the target was believed to be before a correction; 0: no correction.

    """

    TOPIC: ClassVar[str] = 'feedback'
    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': POSITION,
        'velocity': Column('f4', (2,)),
        'covariance': Column('f4', (4, 4)),
        'extent': Column('f4', (2,), float('nan')),
        'template': Column('f4', (TEMPLATE_SIZE,)),
        'track_id': Column('u4'),
        'previous_id': Column('u4'),
    }

    position: NDArray[np.float32]
    velocity: NDArray[np.float32]
    covariance: NDArray[np.float32]
    extent: NDArray[np.float32]
    template: NDArray[np.float32]
    track_id: NDArray[np.uint32]
    previous_id: NDArray[np.uint32]

    def places(self, stamp_ns: int) -> NDArray[np.float64]:
        """Return where the targets are expected at a time, (n, 2) m."""
        seconds = (stamp_ns - self.stamp_ns) * 1e-9
        expected = self.position[:, :2] + self.velocity * seconds
        return np.ascontiguousarray(expected, np.float64)

    def corrections(self) -> dict[int, int]:
        """Return the ids that changed in this tick, old to new."""
        changed = self.previous_id > 0
        return dict(zip(self.previous_id[changed].tolist(), self.track_id[changed].tolist()))
