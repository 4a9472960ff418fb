"""Blobs that are one person each, and those that tracks share; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_2D, FLOATS_3D, INTS_1D, compiled
from mctrack_ros.perception.blob_split.types import MEMBERS, Members
from mctrack_ros.perception.blobs.extraction import iou_of_two

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
NEW = -1
ODD_WIDTH, ODD_HEIGHT = 1.8, 1.25
"""Largest width and height of one person over the expected ones: a full stride; a tall person with
arms raised."""
SINGLE_WIDTH = 1.4
"""Width over the expected one below which a blob shows one person; by trial."""
LEAST_ALIKE = 0.5
"""Intersection over union with its tracks below which a usual blob is new: terrace."""


class SingleBlobs(NamedTuple):
    """
    Blobs judged by their size alone, one row each.

    Attributes
    ----------
    alone : (n,) bool array
        Which have the size of one person and hold at most one track, or match none of their
        tracks, or are a vehicle.
    single : (n,) bool array
        Other blobs of at most one person's size: all tracks but the best match are occluded.
    track : (n,) int64 array
        Row of the track that each is which is alone, -1: none.
    best : (n,) int64 array
        Row of the track in each that is most like it, -1: none.

    """

    alone: Booleans
    single: Booleans
    track: Ints
    best: Ints


SINGLE_BLOBS = types.NamedTuple(
    [types.b1[::1], types.b1[::1], types.i8[::1], types.i8[::1]], SingleBlobs
)


@compiled(SINGLE_BLOBS(INTS_1D, FLOATS_2D, FLOATS_2D, FLOATS_2D, BOOLS_1D, BOOLS_1D))
def single_blobs(
    blob_of: Ints, predicted: Floats, box: Floats, expected: Floats, truncated: Booleans,
    vehicle: Booleans,
) -> SingleBlobs:  # fmt: skip
    """
    Tell which blobs are one person or vehicle each.

    Parameters
    ----------
    blob_of : (t,) int64 array
        Row of the blob that each track is in; -1: none.
    predicted : (t, 4) array
        Boxes of the tracks, px.
    box, expected : (n, 4) and (n, 2) arrays
        Of the blobs, px, and the size of one person there.
    truncated, vehicle : (n,) bool arrays
        Which touch the image's edge, and which are one vehicle each.

    """
    count = len(box)
    alone, single = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    track, best = np.full(count, NEW), np.full(count, NEW)
    for blob in range(count):
        members, most = 0, 0.0
        for row in range(len(blob_of)):
            if blob_of[row] == blob:
                members += 1
                alike = iou_of_two(predicted[row], box[blob])
                if alike > most or members == 1:
                    most, best[blob] = alike, row
        width, height = box[blob, 2], box[blob, 3]
        usual_width, usual_height = expected[blob]
        small = width <= ODD_WIDTH * usual_width and height <= ODD_HEIGHT * usual_height
        whole = members < 2 and (truncated[blob] or small)
        whole = whole or vehicle[blob]
        fits_one = width / usual_width < SINGLE_WIDTH and height / usual_height < ODD_HEIGHT
        single[blob] = not whole and fits_one
        strange = single[blob] and most < LEAST_ALIKE
        alone[blob] = whole or strange
        track[blob] = NEW if strange else best[blob]
    return SingleBlobs(alone, single, track, best)


@compiled(
    types.Tuple([types.i8[::1], MEMBERS])(
        INTS_1D, INTS_1D, FLOATS_2D, FLOATS_3D, FLOATS_2D, FLOATS_2D
    )
)
def members_of(
    shared: Ints, blob_of: Ints, box: Floats, spread: Floats, extent: Floats, template: Floats
) -> tuple[Ints, Members]:
    """
    Return the rows of the tracks that are in some blobs, and what is known of them.

    Parameters
    ----------
    shared : (b,) int64 array
        Rows of the blobs.
    blob_of : (t,) int64 array
        Row of the blob that each track is in; -1: none.
    box, spread : (t, 4) and (t, 2, 2) arrays
        Predicted boxes, px, and the covariance of foot points about the predicted, px².
    extent, template : (t, 2) and (t, 48) arrays
        Sizes, m, and colours of the tracks.

    """
    rows, number = np.empty(len(blob_of), np.int64), np.empty(len(blob_of), np.int64)
    count = 0
    for index in range(len(shared)):
        for row in range(len(blob_of)):
            if blob_of[row] == shared[index]:
                rows[count], number[count] = row, index
                count += 1
    bottom, width = np.empty((count, 2)), template.shape[1]
    spreads, extents = np.empty((count, 2, 2)), np.empty((count, 2))
    templates = np.empty((count, width))
    for place in range(count):
        row = rows[place]
        bottom[place, 0] = box[row, 0] + box[row, 2] * 0.5
        bottom[place, 1] = box[row, 1] + box[row, 3]
        for axis in range(2):
            extents[place, axis] = extent[row, axis]
            for other in range(2):
                spreads[place, axis, other] = spread[row, axis, other]
        for bin in range(width):
            templates[place, bin] = template[row, bin]
    return rows[:count], Members(number[:count], bottom, spreads, extents, templates)
