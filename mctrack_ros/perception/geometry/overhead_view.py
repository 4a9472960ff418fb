"""Views from steeply above, in which an upright line is no model of a body."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping

Floats = NDArray[np.float64]

TALL_M, THICK_M = 1.75, 0.5
"""Height and diameter of the upright cylinder that stands for a body, m."""
CORNERS = 8
"""Points on each of its rims."""
BELOW = 0.2, 0.3
"""Part of the outline below the foot point, as a share of its height: below the first value the
view is from the side, above the second from above."""
GROWTH = 1.4, 1.6
"""The same for the width of the head over that of the feet: the head is nearer."""


def seen_from_above(mapping: GroundMapping, position: Floats) -> tuple[Floats, Floats]:
    """
    Return how bodies look at places, and how far they are seen from above there.

    Parameters
    ----------
    mapping : GroundMapping
        Of the camera.
    position : (n, 2) array
        Places, m.

    Returns
    -------
    metre : (n, 4) array
        As in `SizeTable.table`.
    share : (n,) array
        0: they are seen from the side, and an upright line tells; 1: they are seen from above.

    """
    angle = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
    rim = position[:, None] + THICK_M / 2 * np.column_stack([np.cos(angle), np.sin(angle)])
    feet, heads = (
        mapping.image_from_ground(rim.reshape(-1, 2), height).reshape(rim.shape)
        for height in (0.0, TALL_M)
    )
    outline = np.concatenate([feet, heads], axis=1)
    low, high = outline.min(axis=1), outline.max(axis=1)
    foot = mapping.image_from_ground(position)
    width, height = (high - low).T
    with np.errstate(invalid='ignore', divide='ignore'):  # where nothing can be seen
        lean = (low[:, 0] + high[:, 0] - 2.0 * foot[:, 0]) / height
        below = (high[:, 1] - foot[:, 1]) / height
        growth = _widest(heads) / _widest(feet)
    metre = np.column_stack([width / THICK_M, height / TALL_M, lean, below])
    share = np.fmax(_between(BELOW, below), _between(GROWTH, growth))
    share[~np.isfinite(metre).all(axis=1)] = 0.0
    return metre, share


def _widest(rim: Floats) -> Floats:
    """Return the largest diameter, (n,) px, of (n, CORNERS, 2) rims."""
    across = rim[:, : CORNERS // 2] - rim[:, CORNERS // 2 :]
    widest: Floats = np.hypot(across[..., 0], across[..., 1]).max(axis=1)
    return widest


def _between(limits: tuple[float, float], values: Floats) -> Floats:
    """Return how far, from 0 to 1, values are from the first limit to the second."""
    first, second = limits
    return np.clip((values - first) / (second - first), 0.0, 1.0)
