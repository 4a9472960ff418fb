"""How probably each camera detects what stands where, learned while tracking."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.compiled import inner
from mctrack_ros.fusion.neighbours import cell_slot

Floats = NDArray[np.float64]

SLOTS = 1 << 14
"""Cells that can be told apart; places far from each other may share one."""
LEVELS = 2
"""Fine cells, and the coarse ones that they lie in."""
SEEN, WATCHED = range(2)
"""Which of the seconds of a cell are which."""
COARSENESS = 4
"""Edge of a coarse cell, fine cells."""
LARGEST_PROBABILITY = 0.95
"""Whatever is learned: anything may be hidden behind something now and then."""
MEMORY_S = 30.0
"""What was watched in a cell before its latest so many seconds counts less and less: views
change."""
PRIOR_SECONDS = 1.0
"""How long a place must be watched to count as much as what is assumed of it, s."""


class DetectionProbability:
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
    seconds : (2, slots, 2, cameras) array
        For how long targets were seen, and could be, in the fine and in the coarse cells, s.

    """

    def __init__(self, cameras: int, cell: float, prior: float) -> None:
        self.prior, self.cell = prior, cell
        self.seconds = np.zeros((LEVELS, SLOTS, 2, cameras))


@inner
def _slot(position: Floats, edge: float) -> int:
    """Return where the cell of a position is kept."""
    x, y = int(np.floor(position[0] / edge)), int(np.floor(position[1] / edge))
    return cell_slot(x, y, SLOTS)


@inner
def expect(position: Floats, known: Floats, cell: float, probability: Floats) -> None:
    """
    Change detection probabilities from what is assumed to what is known where a target stands.

    Parameters
    ----------
    position : (2 or more,) array
        m.
    known : (2, slots, 2, cameras) array
        The seconds of the `DetectionProbability`.
    cell : float
        Edge of its fine cells, m.
    probability : (cameras,) array
        Changed in place.

    """
    for level in range(LEVELS - 1, -1, -1):
        slot = _slot(position, cell * COARSENESS**level)
        seen, watched = known[level, slot, SEEN], known[level, slot, WATCHED]
        for camera in range(len(probability)):
            hits = seen[camera] + PRIOR_SECONDS * probability[camera]
            probability[camera] = hits / (watched[camera] + PRIOR_SECONDS)
    for camera in range(len(probability)):
        probability[camera] = min(probability[camera], LARGEST_PROBABILITY)


@inner
def learn(
    position: Floats,
    sure: NDArray[np.bool_],
    is_seen: NDArray[np.bool_],
    is_watched: NDArray[np.bool_],
    seconds: float,
    known: Floats,
    cell: float,
) -> None:
    """
    Note who saw the targets.

    Parameters
    ----------
    position : (n, 2 or more) array
        Where targets stand, m.
    sure : (n,) bool array
        Which of them surely do; the others tell nothing.
    is_seen : (n, cameras) bool array
        Which cameras detected them.
    is_watched : (n, cameras) bool array
        Which cameras could have: their images are there.
    seconds : float
        For how long that speaks, s.
    known : (2, slots, 2, cameras) array
        The seconds of the `DetectionProbability`; changed in place.
    cell : float
        Edge of a fine cell, m.

    """
    for row in range(len(sure)):
        for level in range(LEVELS if sure[row] else 0):
            slot = _slot(position[row], cell * COARSENESS**level)
            seen, watched = known[level, slot, SEEN], known[level, slot, WATCHED]
            for camera in range(len(seen)):
                if is_watched[row, camera]:
                    total = watched[camera] + seconds
                    own = seen[camera] + (seconds if is_seen[row, camera] else 0.0)
                    kept = MEMORY_S / total if total > MEMORY_S else 1.0
                    watched[camera], seen[camera] = kept * total, kept * own
