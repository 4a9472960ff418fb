"""Particles of targets: what a camera sends for each image, and what it is sent back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces.rows import POSITION, Column, Rows

HIDDEN = -8.0
"""Log-likelihood of an image in which the target is hidden; worse ones are not told apart."""


@dataclass(frozen=True, eq=False, slots=True)
class Belief(Rows):
    """
    Particles of targets in views, one row each; those of a target lie together, equally many.

    A camera sends its particles, predicted, with the likelihood of its image. Fusion sends back
    those of all cameras after the messages, equally weighted, and those on the ground, for view 0.

    Attributes
    ----------
    position : (n, 3) float32 array
        On the ground, m; NaN: a particle that the image cannot show, without weight.
    covariance : (n, 2, 2) float32 array
        Of that, m², as far as it comes from the image and the calibration.
    extent : (n, 2) float32 array
        Height and width, m.
    velocity : (n, 2) float32 array
        On the ground, m/s.
    image_state : (n, 6) float32 array
        Column and row of the foot, height, width, px, and velocity, px/s; NaN: not in a view.
    log_likelihood : (n,) float32 array
        Of the image, whether the target shows or is hidden; 0 to `HIDDEN`.
    log_prior : (n,) float32 array
        Log-density of the prediction; NaN: not computed.
    track_id : (n,) uint32 array
        Global id.
    view : (n,) uint32 array
        Which camera's: a digest of its name; 0: no camera's.

    """

    TOPIC: ClassVar[str] = 'belief'
    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': POSITION,
        'covariance': Column('f4', (2, 2)),
        'extent': Column('f4', (2,), float('nan')),
        'velocity': Column('f4', (2,)),
        'image_state': Column('f4', (6,), float('nan')),
        'log_likelihood': Column('f4'),
        'log_prior': Column('f4', (), float('nan')),
        'track_id': Column('u4'),
        'view': Column('u4'),
    }

    position: NDArray[np.float32]
    covariance: NDArray[np.float32]
    extent: NDArray[np.float32]
    velocity: NDArray[np.float32]
    image_state: NDArray[np.float32]
    log_likelihood: NDArray[np.float32]
    log_prior: NDArray[np.float32]
    track_id: NDArray[np.uint32]
    view: NDArray[np.uint32]

    def by_target(self, view: int, count: int = 0) -> dict[int, NDArray[np.int64]]:
        """
        Return the rows of each target in a view, by id in ascending order.

        Targets with another number of particles than the count (0: than most of any) are left out.
        """
        rows = np.flatnonzero(self.view == view)
        ids = self.track_id[rows]
        begin = np.flatnonzero(np.diff(ids, prepend=~ids[:1]))
        counts = np.diff(begin, append=len(ids))
        wanted = count or int(counts.max(initial=0))
        found = zip(ids[begin].tolist(), begin.tolist(), counts.tolist())
        return {key: rows[at : at + wanted] for key, at, own in sorted(found) if own == wanted}
