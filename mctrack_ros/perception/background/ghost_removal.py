"""Foreground that is a hole in the background: someone left who was taken for background."""

from __future__ import annotations

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, INTS_2D, compiled, inner
from mctrack_ros.perception.blobs.extraction import iou

Image = NDArray[np.uint8]
Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
MARGIN = 3
KERNEL = np.ones((3, 3), np.uint8)
PERIOD_S = 0.2  # between searches: as between lessons of the background
PATIENCE_S = 1.0
"""Time that a ghost must stay in one place: passers-by look like one for less on terrace."""
SETTLING_S = 4.0
"""Time from the first background in which ghosts are removed at once."""
SAME_SHARE = 0.7  # intersection over union from which two boxes are one place
EDGE_RATIO, EDGE_DIFFERENCE = 1.25, 6.0
"""Times, and grey levels, by which the background's edges along an outline exceed the image's:
by trial on simulated matches."""


class GhostRemoval:
    """
    Finds ghosts among persons and puts the image into the background there.

    Along a real object's outline the image has edges, along a ghost's the background model; and
    a ghost stays where it is, while texture may make whoever passes look like one for a moment.

    Parameters
    ----------
    settling_s : float
        Time from the first background in which none is waited for, s.

    """

    def __init__(self, settling_s: float = SETTLING_S) -> None:
        self._settling_ns = round(settling_s * 1e9)
        self.restart()

    def restart(self) -> None:
        """Forget all suspicion."""
        self._box = np.zeros((0, 4))
        self._since_ns = np.zeros(0, np.int64)
        self._first_ns: int | None = None
        self._next_ns = 0

    def look(
        self, model: Image, image: Image, mask: Image, box: NDArray[np.floating], stamp_ns: int
    ) -> NDArray[np.bool_]:
        """
        Look at persons, if it is time again, and heal what has long looked like a ghost.

        Parameters
        ----------
        model : (h, w, 3) uint8 array
            Background; changed in place where a ghost is.
        image : (h, w, 3) uint8 array
            Image.
        mask : (h, w) uint8 array
            Foreground.
        box : (n, 4) array
            Persons to look at: left, top, width, height in pixels of these images.
        stamp_ns : int
            Time of the image, ns.

        Returns
        -------
        (n,) bool array
            Which were healed.

        """
        healed = np.zeros(len(box), np.bool_)
        if stamp_ns < self._next_ns:
            return healed
        self._next_ns = stamp_ns + round(PERIOD_S * 1e9)
        cells = np.rint(box).astype(np.int64)
        edges = outline_edges(image, model, mask, cells)
        suspicious = (edges[:, 1] > EDGE_RATIO * edges[:, 0]) & (
            edges[:, 1] - edges[:, 0] > EDGE_DIFFERENCE
        )
        since = self._suspected_since(box, stamp_ns)
        healed = suspicious & (stamp_ns - since >= self._patience_ns(stamp_ns))
        for row in cells[healed]:
            part = _around(row)
            hole = cv2.dilate(mask[part], KERNEL, iterations=MARGIN - 1)
            cv2.copyTo(image[part], hole, model[part])
        waiting = suspicious & ~healed
        self._box, self._since_ns = box[waiting].astype(np.float64), since[waiting]
        return healed

    def _patience_ns(self, stamp_ns: int) -> int:
        if self._first_ns is None:
            self._first_ns = stamp_ns
        settled = stamp_ns - self._first_ns >= self._settling_ns
        return round(PATIENCE_S * 1e9) if settled else 0

    def _suspected_since(self, box: NDArray[np.floating], stamp_ns: int) -> NDArray[np.int64]:
        """Return since when something has been suspected at the places of boxes, ns."""
        if not len(self._box):
            return np.full(len(box), stamp_ns, np.int64)
        same = iou(box.astype(np.float64), self._box) >= SAME_SHARE
        since: NDArray[np.int64] = np.where(same, self._since_ns[None], stamp_ns).min(axis=1)
        return since


def _around(box: NDArray[np.integer]) -> tuple[slice, slice]:
    left, top, width, height = box.tolist()
    return (
        slice(max(top - MARGIN, 0), top + height + MARGIN),
        slice(max(left - MARGIN, 0), left + width + MARGIN),
    )


@inner
def _ranges(image: Image, y: int, part: Ints, low: Image, high: Image, out: Image) -> None:
    """Write the (w, 3) ranges of the channels over 3 x 3 along a row; the margins repeat."""
    above, below = max(y - 1, part[1]), min(y + 1, part[3] - 1)
    one = image[above, part[0] : part[2]].reshape(-1)
    two = image[y, part[0] : part[2]].reshape(-1)
    three = image[below, part[0] : part[2]].reshape(-1)
    size = len(one)
    for index in range(size):  # flat, as below: so the compiler makes vectors of it
        low[3 + index] = min(one[index], two[index], three[index])
        high[3 + index] = max(one[index], two[index], three[index])
    for channel in range(3):
        low[channel], low[3 + size + channel] = low[3 + channel], low[size + channel]
        high[channel], high[3 + size + channel] = high[3 + channel], high[size + channel]
    for index in range(size):
        least = min(low[index], low[index + 3], low[index + 6])
        out[index] = np.uint8(max(high[index], high[index + 3], high[index + 6]) - least)


@inner
def _outline(mask: Image, y: int, part: Ints, filled: Image, marked: Bools) -> None:
    """Write for a row of a part at which of its pixels the mask varies over 3 x 3."""
    left, top, right, bottom = part
    above, below = mask[max(y - 1, top), left:right], mask[min(y + 1, bottom - 1), left:right]
    middle = mask[y, left:right]
    for x in range(len(middle)):
        filled[x + 1] = (above[x] > 0) + (middle[x] > 0) + (below[x] > 0)
    filled[0], filled[len(middle) + 1] = filled[1], filled[len(middle)]
    for x in range(len(middle)):
        total = filled[x] + filled[x + 1] + filled[x + 2]
        marked[x] = 0 < total < 9


@inner
def _edges(
    images: tuple[Image, Image], mask: Image, part: Ints, work: Image
) -> tuple[float, float]:
    """Return the mean gradients of both images along the outline in a part."""
    width, totals, count = part[2] - part[0], np.zeros(2, np.int64), 0
    filled, marked = np.zeros(width + 2, np.uint8), np.zeros(width, np.bool_)
    columns = np.empty(width, np.int64)
    for y in range(part[1], part[3]):
        _outline(mask, y, part, filled, marked)
        found = 0
        for x in range(width):
            if marked[x]:
                columns[found] = x
                found += 1
        count += found
        if found == 0:
            continue
        for which in range(2):
            _ranges(images[which], y, part, work[0], work[1], work[2])
            for place in range(found):
                x = columns[place]
                for channel in range(3):
                    totals[which] += work[2, 3 * x + channel]
    return totals[0] / max(3 * count, 1), totals[1] / max(3 * count, 1)


@compiled(types.f8[:, ::1](BYTES_3D, BYTES_3D, BYTES_2D, INTS_2D))
def outline_edges(image: Image, model: Image, mask: Image, box: Ints) -> Floats:
    """
    Measure the edges along the outline of the foreground in boxes.

    Parameters
    ----------
    image, model : (h, w, 3) uint8 array
        Image and background.
    mask : (h, w) uint8 array
        Foreground.
    box : (n, 4) int64 array
        Left, top, width, height, px.

    Returns
    -------
    (n, 2) float64 array
        Mean gradient, grey levels, of the image and of the background; 0 without an outline.

    """
    height, width = mask.shape
    edges, part = np.zeros((len(box), 2)), np.empty(4, np.int64)
    work = np.empty((3, 3 * width + 6), np.uint8)
    for index in range(len(box)):
        left, top = box[index, 0], box[index, 1]
        across, down = box[index, 2], box[index, 3]
        part[0], part[1] = max(left - MARGIN, 0), max(top - MARGIN, 0)
        part[2] = min(left + across + MARGIN, width)
        part[3] = min(top + down + MARGIN, height)
        same = -1
        for other in range(index):
            if (
                box[other, 0] == left
                and box[other, 1] == top
                and box[other, 2] == across
                and box[other, 3] == down
            ):
                same = other
        if same >= 0:
            edges[index, 0], edges[index, 1] = edges[same, 0], edges[same, 1]
        elif part[0] < part[2] and part[1] < part[3]:
            edges[index, 0], edges[index, 1] = _edges((image, model), mask, part, work)
    return edges
