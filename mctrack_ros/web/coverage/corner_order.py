"""Where in the order of a polygon's corners a new one belongs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_NEAR = 0.1
"""Distance from an edge, in its lengths, up to which a new corner divides it."""


def place_in_order(corners: Sequence[tuple[float, float]], new: tuple[float, float]) -> int:
    """
    Return the index that a new corner takes among others.

    One that is placed near the middle of an edge divides it. Otherwise it comes last, as whoever
    clicks around a region means it; or, where the polygon would cross itself so, where it makes
    the way around it least longer.

    Parameters
    ----------
    corners : sequence of (float, float)
        Around the polygon.
    new : (float, float)
        Where the new corner is, in the same unit.

    """
    last = len(corners)
    if last < 3:
        return last
    start, place = np.array(corners), np.array(new)
    stop = np.roll(start, -1, axis=0)
    divided = _divided(start, stop, place)
    if divided is not None:
        return divided + 1
    if shapely.Polygon([*corners, new]).is_valid:
        return last
    detour = np.hypot(*(place - start).T) + np.hypot(*(stop - place).T)
    return int((detour - np.hypot(*(stop - start).T)).argmin()) + 1


def _divided(start: Floats, stop: Floats, place: Floats) -> int | None:
    """Return the edge near the middle of which a place lies, if there is one."""
    along = stop - start
    square = np.maximum((along**2).sum(axis=1), 1e-12)
    share = ((place - start) * along).sum(axis=1) / square
    away = np.hypot(*(place - start - share[:, None] * along).T) / np.sqrt(square)
    near = (share > _NEAR) & (share < 1 - _NEAR) & (away < _NEAR)
    return int(np.where(near, away, np.inf).argmin()) if near.any() else None
