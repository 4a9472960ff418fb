"""Association: the gated pairs of a tick in, their probabilities out."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.association.solvers.covering_graph import CoveringGraph
from mctrack_ros.fusion.association.solvers.gnn import (
    GlobalNearestNeighbour,
    WeighedNearestNeighbour,
)
from mctrack_ros.fusion.association.solvers.jpda import JointProbabilisticData
from mctrack_ros.fusion.association.solvers.nearest import NearestNeighbour
from mctrack_ros.fusion.association.solvers.pairs import Pairs


class Associator(Protocol):
    """How probable the pairs of a tick are."""

    def probabilities(self, pairs: Pairs) -> NDArray[np.float64]:
        """
        Return the (k,) probabilities.

        Those of one slot sum to 1 at most; those of one detection too, unless tracks may share it.
        """
        ...


ASSOCIATORS: dict[str, type[Associator]] = {
    'weighed_gnn': WeighedNearestNeighbour,
    'gnn': GlobalNearestNeighbour,
    'jpda': JointProbabilisticData,
    'nearest': NearestNeighbour,
    'covering_graph': CoveringGraph,
}

__all__ = ['ASSOCIATORS', 'Associator', 'Pairs']
