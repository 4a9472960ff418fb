"""Who touches whom: connected foreground, cut where it is weak."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.picture import Picture

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NOWHERE = -1


def contacts(blob: Ints, box: Floats, blob_box: Floats, picture: Picture, share: float) -> Ints:
    """
    Tell which persons are connected by strong foreground.

    A blob's rim is blurred, so two persons who only stand close share it. Cut where it differs
    from the background by less than a share of its mean, it falls into its parts; everyone is in
    the part that fills most of the own box.

    Parameters
    ----------
    blob : (n,) int64 array
        Row of the blob that each person is in; -1: not seen.
    box : (n, 4) array
        The persons', px.
    blob_box : (m, 4) array
        The blobs', px.
    picture : Picture
        With its foreground.
    share : float
        Of the blob's mean difference.

    Returns
    -------
    (n,) int64 array
        The same number for those that touch, directly or through others; -1: not seen.

    """
    seen = blob >= 0
    found = np.where(seen, blob, NOWHERE)
    count = np.bincount(blob[seen], minlength=1)
    free = len(blob_box)
    for shared in np.flatnonzero(count > 1).tolist():
        rows = np.flatnonzero(blob == shared)
        left, top, width, height = np.rint(blob_box[shared] / picture.scale).astype(int).tolist()
        part = np.s_[top : top + height, left : left + width]
        strong = _strong(picture.difference[part], picture.mask[part], share)
        parts, label = cv2.connectedComponents(strong, connectivity=8, ltype=cv2.CV_16U)
        inside = box[rows] / picture.scale - [left, top, 0, 0]
        found[rows] = free + _fullest(np.asarray(label, np.uint16), inside, parts)
        free += parts
    return found


def _strong(
    difference: NDArray[np.uint8], mask: NDArray[np.uint8], share: float
) -> NDArray[np.uint8]:
    foreground = mask > 0
    level = share * float(difference[foreground].mean()) if foreground.any() else 0.0
    return np.asarray(foreground & (difference > level), np.uint8)


def _fullest(label: NDArray[np.uint16], box: Floats, parts: int) -> Ints:
    """Return the label, not 0 unless there is no other, that fills most of each box."""
    low = np.floor(np.clip(box[:, :2], 0, None)).astype(int)
    high = np.ceil(box[:, :2] + box[:, 2:]).astype(int)
    fullest = np.zeros(len(box), np.int64)
    for row, ((left, top), (right, bottom)) in enumerate(zip(low.tolist(), high.tolist())):
        pixels = np.bincount(label[top:bottom, left:right].ravel(), minlength=parts)
        pixels[0] = 0
        fullest[row] = pixels.argmax()
    return fullest
