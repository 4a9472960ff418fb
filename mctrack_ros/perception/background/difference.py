"""How an image differs from the background, pixel by pixel; compiled."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_3D, compiled

Image = NDArray[np.uint8]
IMAGE = types.Array(types.u1, 2, 'C')
SAMPLED_PX = 16
"""Every so many pixels, in both directions, count for the median."""


@compiled(types.i8(BYTES_3D, BYTES_3D, IMAGE))
def subtract(image: Image, model: Image, difference: Image) -> int:
    """
    Write the largest of the channels' differences (event-tracking paper, eq. (1)).

    Parameters
    ----------
    image, model : (h, w, 3) uint8 array
        Image and background.
    difference : (h, w) uint8 array
        Is overwritten.

    Returns
    -------
    int
        Median difference of a sample of the pixels, grey levels.

    """
    new, old, out = image.reshape(-1), model.reshape(-1), difference.reshape(-1)
    for index in range(len(out)):  # flat: so the compiler makes vectors of it
        largest = np.uint8(0)
        for channel in range(3):
            one, other = new[3 * index + channel], old[3 * index + channel]
            largest = max(largest, np.uint8(max(one, other) - min(one, other)))
        out[index] = largest
    histogram, samples = np.zeros(256, np.int64), 0
    height, width = difference.shape
    for y in range(0, height, SAMPLED_PX):
        for x in range(0, width, SAMPLED_PX):
            histogram[difference[y, x]] += 1
            samples += 1
    total, median = histogram[0], 0
    while 2 * total < samples:
        median += 1
        total += histogram[median]
    return median
