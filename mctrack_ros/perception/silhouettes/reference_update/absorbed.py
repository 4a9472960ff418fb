"""Objects that were put into the background, and what is seen when they leave it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.background.light import Gains, relit
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.silhouettes.features import Floats

Image = NDArray[np.uint8]


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
    before : (h, w, 3) uint8 array
        The background that it hides.
    mask : (h, w) uint8 array
        255 where it was foreground.
    light : (3,) float64 array
        How bright the background was at that time.
    stamp_ns : int
        When it was inserted.

    """

    local_id: int
    box: NDArray[np.int64]
    centroid: Floats
    before: Image
    mask: Image
    light: Gains
    stamp_ns: int


def uncovered(
    entry: Inserted, background: Background, image: Image, mask: Image, share: float
) -> bool:
    """
    Take an object that drives off out of the background again; beyond the paper.

    Where the image shows again what the object had hidden, it is leaving: at once there is
    neither a hole nor a vehicle that is half background.

    Parameters
    ----------
    entry : Inserted
        The object.
    background : Background
        Is changed if it leaves.
    image : (h, w, 3) uint8 array
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
    assert background.model is not None
    window = window_of(entry.box)
    enough = share * cv2.countNonZero(entry.mask)
    seen = cv2.bitwise_and(mask[window], entry.mask)
    if cv2.countNonZero(seen) < enough:
        return False
    before = relit(entry.before, background.light / entry.light)
    differs = cv2.absdiff(image[window], before).max(axis=2) > background.threshold
    if np.count_nonzero((seen > 0) & ~differs) < enough:
        return False
    inside = entry.mask > 0
    background.model[window][inside] = before[inside]
    mask[window][inside] = 255 * differs[inside]
    return True


def window_of(box: NDArray[np.integer] | Floats) -> tuple[slice, slice]:
    """Return the rows and columns of a box."""
    left, top, width, height = box.astype(int).tolist()
    return np.s_[top : top + height, left : left + width]
