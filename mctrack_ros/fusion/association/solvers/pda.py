"""Probabilistic data association: every track for itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.association.solvers.pairs import Pairs


class ProbabilisticData:
    """
    PDA: a track's pairs compete with each other and with its being missed.

    Other tracks do not count (Bar-Shalom and Tse 1975, "Tracking in a cluttered environment with
    probabilistic data association").
    """

    def probabilities(self, pairs: Pairs) -> NDArray[np.float64]:
        """Return the (k,) probabilities; with the missed detection a slot's sum to 1."""
        total = 1.0 + np.bincount(pairs.slot, pairs.likelihood)
        return np.asarray(pairs.likelihood / total[pairs.slot])
