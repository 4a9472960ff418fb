"""How much likelier a cell's track is a target than somebody new: by state and colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.association.config import JointAssociationConfig
from mctrack_ros.fusion.motion.models import INITIAL_SPEED_SIGMA
from mctrack_ros.fusion.reid.lost_targets import ARRIVAL_DENSITY

Floats = NDArray[np.float64]
Templates = NDArray[np.float32]

COLOURS = JointAssociationConfig()
"""What colours are worth, as in a cell."""


def costs(
    mean: Floats, covariance: Floats, template: Templates, expected: Floats, spread: Floats
) -> Floats:
    """
    Return -2 log, (k,), of how much likelier each track is its target than somebody new.

    As `LostTargets` has it for one cell, but both states have errors of their own.

    Parameters
    ----------
    mean, covariance : (k, 4), (k, 4, 4) arrays
        Of cells' tracks.
    template : (2, k, 48) array
        Colours of the tracks and of the targets; zero: not known.
    expected, spread : (k, 4), (k, 4, 4) arrays
        Of the targets by what others say.

    """
    gap, variance = mean - expected, INITIAL_SPEED_SIGMA**2
    together = covariance + spread
    squared = (gap[:, None] @ np.linalg.solve(together, gap[:, :, None]))[:, 0, 0]
    his = squared + np.linalg.slogdet(2 * np.pi * together)[1]
    speed = (mean[:, 2:] ** 2).sum(axis=1)
    new = speed / variance + 2 * np.log(2 * np.pi * variance) - 2 * np.log(ARRIVAL_DENSITY)
    return np.asarray(his - new + colour_costs(*template))


def colour_costs(one: Templates, other: Templates) -> Floats:
    """Return -2 log, (k,), of how much likelier colours (k, 48) are the same one's; 0: unknown."""
    shared = np.sqrt(np.maximum(one, 0) * np.maximum(other, 0)).sum(axis=1)
    differ = np.clip(1.0 - shared, 0.0, 1.0)
    is_known = one.any(axis=1) & other.any(axis=1)
    more = COLOURS.appearance_weight * (differ - COLOURS.usual_difference)
    return np.asarray(np.where(is_known, more, 0.0), np.float64)
