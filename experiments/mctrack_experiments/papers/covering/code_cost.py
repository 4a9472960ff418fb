"""The cost of a pair in the covering-graph paper's code, which is not that of its text."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.association.likelihood import differences
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.covering import CoveringAssociation
from mctrack_ros.fusion.update.update import ASSOCIATIONS

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

METHOD = 'covering_graph'
SPATIAL_WEIGHT, APPEARANCE_WEIGHT = 0.7, 0.3
"""Of the cost in the paper's code."""
APPEARANCE_SCALE = 100.0
"""What it multiplies 1 - Bhattacharyya coefficient by."""
LARGEST_CODE_COST = 100.0
"""A pair that costs more there is none."""
PIXELS_PER_METRE = 50.0
"""What stands for the pixels of its distances: in images of 640 x 480 such as PETS2006's a
person of 1.7 m is about 85 px tall, px/m."""
USUAL_DIFFERENCE = 0.15
"""1 - Bhattacharyya coefficient where it is not known."""


class CodeCovering(CoveringAssociation):
    """The covering graph by distance and colours."""

    @staticmethod
    def costs(table: TrackTable, batch: Batch, track: Indices, row: Indices) -> Floats:
        """Return what pairs (k,) cost; infinite: there is none."""
        seconds = batch.seconds[batch.image[row], None]
        place = table.mean[track, :2] + seconds * table.mean[track, 2:]
        metres = np.hypot(*(batch.position[row] - place).T)
        templates = table.template, batch.detections.template, batch.is_described
        more = differences(*templates, track, row, USUAL_DIFFERENCE)
        return code_cost(metres, more + USUAL_DIFFERENCE)


def code_cost(metres: Floats, difference: Floats) -> Floats:
    """Return costs of distances (k,), m, and of 1 - Bhattacharyya coefficients (k,)."""
    spatial, appearance = PIXELS_PER_METRE * metres, APPEARANCE_SCALE * difference
    cost = SPATIAL_WEIGHT * spatial + APPEARANCE_WEIGHT * appearance
    return np.where(cost <= LARGEST_CODE_COST, cost, np.inf)


@contextmanager
def as_in_the_code(wanted: bool) -> Iterator[None]:
    """Let the pairs of the covering graph cost as in the code meanwhile, if wanted."""
    usual = ASSOCIATIONS[METHOD]
    ASSOCIATIONS[METHOD] = CodeCovering if wanted else usual
    try:
        yield
    finally:
        ASSOCIATIONS[METHOD] = usual
