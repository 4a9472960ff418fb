"""Objects that were put into the background, and what is seen when they leave it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.silhouettes.background.model import LowPassBackground
from mctrack_ros.perception.silhouettes.features import Floats

Grey = NDArray[np.uint8]


@dataclass(frozen=True, eq=False, slots=True)
class Inserted:
    """
    An entry of the list of recently inserted objects.

    Attributes
    ----------
    local_id : int
        What it was called.
    box : (4,) int array
        Its rectangle, px.
    centroid : (2,) float array
        Its centroid, px.
    before : (h, w) uint8 array
        The background that it hides.
    mask : (h, w) uint8 array
        255 where it was foreground.
    light : float
        The background's brightness at that time.
    stamp_ns : int
        When it was inserted.

    """

    local_id: int
    box: NDArray[np.int64]
    centroid: Floats
    before: Grey
    mask: Grey
    light: float
    stamp_ns: int


def uncovered(
    entry: Inserted, background: LowPassBackground, grey: Grey, mask: Grey, share: float
) -> bool:
    """
    Take an object that drives off out of the background again; beyond the paper.

    Where the image shows again what the object had hidden, it is leaving: at once there is
    neither a hole nor a vehicle that is half background.

    Parameters
    ----------
    entry : Inserted
        The object.
    background : LowPassBackground
        Is changed if it leaves.
    grey : (h, w) uint8 array
        The smoothed image.
    mask : (h, w) uint8 array
        Foreground; is changed if it leaves.
    share : float
        Share of the object behind which the old background must be seen.

    Returns
    -------
    bool
        Whether it leaves.

    """
    window = window_of(entry.box)
    enough = share * cv2.countNonZero(entry.mask)
    seen = cv2.bitwise_and(mask[window], entry.mask)
    if cv2.countNonZero(seen) < enough:
        return False
    gain = background.light / entry.light
    before = np.asarray(cv2.convertScaleAbs(entry.before, alpha=gain), np.uint8)
    differs = cv2.absdiff(grey[window], before) > background.threshold
    if np.count_nonzero((seen > 0) & ~differs) < enough:
        return False
    background.restore(before, entry.box, entry.mask)
    mask[window][entry.mask > 0] = 255 * differs[entry.mask > 0]
    return True


def window_of(box: NDArray[np.integer] | Floats) -> tuple[slice, slice]:
    """Return the rows and columns of a box."""
    left, top, width, height = box.astype(int).tolist()
    return np.s_[top : top + height, left : left + width]
