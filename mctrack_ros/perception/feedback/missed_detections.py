"""Places where the fusion node expects a target and the camera sees bare background."""

from __future__ import annotations

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, FLOATS_2D, compiled
from mctrack_ros.interfaces import Detections
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.perception.feedback.persons_in_view import PersonsInView

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Mask = NDArray[np.uint8]
LEAST_SHARE = 0.05
"""Share of a box that must be foreground for somebody to be there, however small or hidden."""


def missed_detections(
    in_view: PersonsInView, part: Ints, frame: Frame, ignored: Mask | None, stamp_ns: int
) -> Detections:
    """
    Return one vacant row for each target that should be seen and is not (see `Detections`).

    What a camera does not see where it looks tells as much as what it sees ("negative
    information", Koch 2004). A target whom others hide is where their foreground is, and of one
    who is too small to be an object there are some pixels: where there is hardly any foreground
    at all, nobody is.

    Parameters
    ----------
    in_view : PersonsInView
        Everybody in view, with fresh feedback.
    part : (n,) int64 array
        The part of the foreground each is in (see `contacts`); -1: not seen.
    frame : Frame
        With its foreground.
    ignored : (height, width) uint8 array or None
        0 where the camera does not look.
    stamp_ns : int
        Time of the image, ns.

    """
    missed = np.flatnonzero((part < 0) & (in_view.local_id == 0) & (in_view.track_id > 0))
    if not len(missed):
        return Detections.build(stamp_ns)
    rows = missed[_shares(frame.found, in_view.box[missed] / frame.scale) < LEAST_SHARE]
    if ignored is not None and len(rows):
        rows = rows[_shares(ignored, in_view.box[rows]) == 1.0]
    return Detections.vacant(stamp_ns, in_view.track_id[rows], in_view.box[rows])


@compiled(types.f8[::1](BYTES_2D, FLOATS_2D))
def _shares(mask: Mask, box: Floats) -> Floats:
    """Return which share, (n,), of (n, 4) boxes is set; 1 of those not wholly in the image."""
    height, width = mask.shape
    shares = np.ones(len(box))
    for row, (left, top, wide, high) in enumerate(box):
        right, bottom = left + wide, top + high
        if not (left >= 0 and top >= 0 and right <= width and bottom <= height):
            continue
        filled, pixels = 0, 0
        for y in range(int(top), math.ceil(bottom)):
            for x in range(int(left), math.ceil(right)):
                filled += mask[y, x] > 0
                pixels += 1
        shares[row] = filled / max(pixels, 1)
    return shares
