"""One image as the tracker sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """
    An image, reduced, with its foreground.

    Attributes
    ----------
    image : (h, w, 3) uint8 array
        Blue, green, red.
    found : (h, w) uint8 array
        Its foreground as found, 255.
    mask : (h, w) uint8 array
        The same without what is only a few pixels wide, and without shade beside objects.
    objects : (h, w) uint8 array
        The part of it that no change of light explains, 255.
    background : (h, w, 3) uint8 array
        Without what moves.
    difference : (h, w) uint8 array
        Largest of the channels' differences of the two.
    scale : float
        Pixels of the camera's image to one of these.
    balance : (3,) array
        Factors of blue, green and red that make cameras' colours comparable.

    """

    image: NDArray[np.uint8]
    found: NDArray[np.uint8]
    mask: NDArray[np.uint8]
    objects: NDArray[np.uint8]
    background: NDArray[np.uint8]
    difference: NDArray[np.uint8]
    scale: float
    balance: NDArray[np.float64]
