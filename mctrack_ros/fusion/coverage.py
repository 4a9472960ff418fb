"""How probably each camera detects what stands where, learned while tracking."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SLOTS = 1 << 14
"""Cells that can be told apart; places far from each other may share one."""
COARSENESS = 4
"""Edge of a coarse cell, fine cells."""
LARGEST_PROBABILITY = 0.95
"""Whatever is learned: anything may be hidden behind something now and then."""
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

    """

    def __init__(self, cameras: int, cell: float, prior: float) -> None:
        self._prior = prior
        self._edges = (cell, cell * COARSENESS)
        self._seen = [np.zeros((SLOTS, cameras)) for _ in self._edges]
        self._watched = [np.zeros((SLOTS, cameras)) for _ in self._edges]

    def probability(self, position: Floats) -> Floats:
        """
        Return the detection probabilities, (n, cameras), at (n, 2) ground positions, m.

        They are the means of beta distributions whose prior is the coarse cell's mean.
        """
        fine, coarse = (_slots(position, edge) for edge in self._edges)
        prior = self._posterior(1, coarse, self._prior)
        return np.minimum(self._posterior(0, fine, prior), LARGEST_PROBABILITY)

    def learn(
        self, position: Floats, seen: NDArray[np.bool_], watched: NDArray[np.bool_], seconds: float
    ) -> None:
        """
        Note who saw the targets.

        Parameters
        ----------
        position : (n, 2) array
            Where targets surely stand, m.
        seen : (n, cameras) bool array
            Which cameras detected them.
        watched : (n, cameras) bool array
            Which cameras could have: their pictures are there.
        seconds : float
            For how long that speaks, s.

        """
        for level, edge in enumerate(self._edges):
            slots = _slots(position, edge)
            np.add.at(self._seen[level], slots, seconds * (seen & watched))
            np.add.at(self._watched[level], slots, seconds * watched)

    def _posterior(self, level: int, slots: NDArray[np.int64], prior: Floats | float) -> Floats:
        seen, watched = self._seen[level][slots], self._watched[level][slots]
        mean: Floats = (seen + PRIOR_SECONDS * prior) / (watched + PRIOR_SECONDS)
        return mean


def _slots(position: Floats, edge: float) -> NDArray[np.int64]:
    """Return where the cells of positions are kept."""
    cell = np.floor(position / edge).astype(np.int64)
    return (cell[:, 0] * 73_856_093 ^ cell[:, 1] * 19_349_663) % SLOTS
