"""The step of the approximate median: one grey level towards a picture; compiled."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, compiled

Image = NDArray[np.uint8]
PICTURE = types.Array(types.u1, 3, 'C')


@compiled(types.void(PICTURE, BYTES_3D, BYTES_2D))
def approach(model: Image, image: Image, kept: Image) -> None:
    """
    Move every pixel of a model by one grey level towards a picture.

    Parameters
    ----------
    model, image : (h, w, 3) uint8 array
        The model, changed in place, and the picture.
    kept : (h, w) uint8 array
        Not 0 where the model stays as it is.

    """
    old, new, stays = model.reshape(-1), image.reshape(-1), kept.reshape(-1)
    for index in range(len(stays)):  # flat: so the compiler makes vectors of it
        moves = np.uint8(stays[index] == 0)
        for channel in range(3):
            place = 3 * index + channel
            up, down = np.uint8(new[place] > old[place]), np.uint8(new[place] < old[place])
            old[place] = np.uint8(old[place] + np.uint8(up & moves) - np.uint8(down & moves))
