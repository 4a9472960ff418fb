"""How probably each camera detects what stands where, learned while tracking."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    BOOLS_1D,
    BOOLS_2D,
    COLUMN_2D,
    COLUMN_FLAGS,
    FLOATS_2D,
    FLOATS_3D,
    compiled,
    inner,
)
from mctrack_ros.fusion.neighbours import cell_slot

Floats = NDArray[np.float64]

SLOTS = 1 << 14
"""Cells that can be told apart; places far from each other may share one."""
LEVELS = 2
"""Fine cells, and the coarse ones that they lie in."""
COARSENESS = 4
"""Edge of a coarse cell, fine cells."""
LARGEST_PROBABILITY = 0.95
"""Whatever is learned: anything may be hidden behind something now and then."""
MEMORY_S = 30.0
"""What was watched in a cell before its latest so many seconds counts less and less: views
change."""
PRIOR_SECONDS = 1.0
"""How long a place must be watched to count as much as what is assumed of it, s."""


class CoverageMap:
    """
    Detection probabilities by camera and place: of fine cells, with coarse ones as their prior.

    Parameters
    ----------
    cameras : int
        How many there are.
    cell : float
        Edge of a fine cell, m.
    prior : float
        Detection probability where nothing is known yet.

    Attributes
    ----------
    seen, watched : (2, slots, cameras) arrays
        For how long targets were seen, and could be, in the fine and in the coarse cells, s.

    """

    def __init__(self, cameras: int, cell: float, prior: float) -> None:
        self.prior, self.cell = prior, cell
        self.seen = np.zeros((LEVELS, SLOTS, cameras))
        self.watched = np.zeros((LEVELS, SLOTS, cameras))

    def probability(self, position: Floats, wanted: NDArray[np.bool_]) -> Floats:
        """
        Return detection probabilities at ground positions.

        They are the means of beta distributions whose prior is the coarse cell's mean.

        Parameters
        ----------
        position : (n, 2 or more) array
            m.
        wanted : (n,) bool array
            Where they are wanted; elsewhere the prior is returned.

        Returns
        -------
        (n, cameras) array

        """
        prior = np.full((len(position), self.seen.shape[2]), self.prior)
        return probabilities(position, wanted, self.seen, self.watched, self.cell, prior)


@inner
def _slot(position: Floats, edge: float) -> int:
    """Return where the cell of a position is kept."""
    x, y = int(np.floor(position[0] / edge)), int(np.floor(position[1] / edge))
    return cell_slot(x, y, SLOTS)


@compiled(types.f8[:, ::1](COLUMN_2D, BOOLS_1D, FLOATS_3D, FLOATS_3D, types.f8, FLOATS_2D))
def probabilities(
    position: Floats,
    wanted: NDArray[np.bool_],
    seen: Floats,
    watched: Floats,
    cell: float,
    prior: Floats,
) -> Floats:
    """
    Return what `CoverageMap.probability` does; to be called by compiled functions, too.

    What is assumed where nothing is known, (n, cameras), is the target's own.
    """
    probability = np.minimum(prior, LARGEST_PROBABILITY)
    for row in np.flatnonzero(wanted):
        probability[row] = prior[row]
        for level in range(LEVELS - 1, -1, -1):
            slot = _slot(position[row], cell * COARSENESS**level)
            for camera in range(seen.shape[2]):
                known = seen[level, slot, camera] + PRIOR_SECONDS * probability[row, camera]
                probability[row, camera] = known / (watched[level, slot, camera] + PRIOR_SECONDS)
        for camera in range(seen.shape[2]):
            probability[row, camera] = min(probability[row, camera], LARGEST_PROBABILITY)
    return probability


@compiled(
    types.void(
        COLUMN_2D,
        COLUMN_FLAGS,
        BOOLS_2D,
        BOOLS_2D,
        types.f8,
        types.f8[:, :, ::1],
        types.f8[:, :, ::1],
        types.f8,
    )
)
def learn(
    position: Floats,
    sure: NDArray[np.bool_],
    is_seen: NDArray[np.bool_],
    is_watched: NDArray[np.bool_],
    seconds: float,
    seen: Floats,
    watched: Floats,
    cell: float,
) -> None:
    """
    Note who saw the targets; to be called by compiled functions, too.

    Parameters
    ----------
    position : (n, 2 or more) array
        Where targets stand, m.
    sure : (n,) bool array
        Which of them surely do; the others tell nothing.
    is_seen : (n, cameras) bool array
        Which cameras detected them.
    is_watched : (n, cameras) bool array
        Which cameras could have: their pictures are there.
    seconds : float
        For how long that speaks, s.
    seen, watched : (2, slots, cameras) arrays
        Of the `CoverageMap`; changed in place.
    cell : float
        Edge of a fine cell, m.

    """
    for row in range(len(sure)):
        for level in range(LEVELS if sure[row] else 0):
            slot = _slot(position[row], cell * COARSENESS**level)
            for camera in range(seen.shape[2]):
                if is_watched[row, camera]:
                    total = watched[level, slot, camera] + seconds
                    kept = min(MEMORY_S / total, 1.0)
                    watched[level, slot, camera] = kept * total
                    own = seconds if is_seen[row, camera] else 0.0
                    seen[level, slot, camera] = kept * (seen[level, slot, camera] + own)
