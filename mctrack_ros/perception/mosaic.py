"""Images in which nobody is recognised: who may be a person becomes cells of one colour."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Detections, Foreground
from mctrack_ros.perception.output import CameraOutput

Image = NDArray[np.uint8]

ROWS = 18
"""Cells to the height of an image, at most."""
HEADS = 7
"""Cells to the height of the tallest box, at most: a head fits into one, a face is one colour."""


def without_faces(image: Image, output: CameraOutput, predicted: NDArray[np.floating]) -> Image:
    """
    Return a copy of an image in which foreground and boxes are cells of one colour.

    Where the camera does not know what is foreground, because it learns the background or has
    moved, this is the whole image. Somebody whom it takes for background stays visible.

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        The image, BGR.
    output : CameraOutput
        What is seen in it.
    predicted : (n, 4) array
        Further boxes: left, top, width, height, px; those that are not finite are passed over.

    """
    height, width = image.shape[:2]
    boxes = np.concatenate([output.detections.box, np.asarray(predicted).reshape(-1, 4)])
    boxes = boxes[np.isfinite(boxes).all(axis=1)]
    side = max(height / ROWS, boxes[:, 3].max(initial=0.0) / HEADS)
    shape = rows, columns = max(int(height / side), 1), max(int(width / side), 1)
    cells = cv2.resize(image, shape[::-1], interpolation=cv2.INTER_AREA)
    hidden = _foreground(output, shape)
    scale = np.array([columns / width, rows / height])
    low = np.floor(boxes[:, :2] * scale).astype(int).clip(0)
    high = np.ceil((boxes[:, :2] + boxes[:, 2:]) * scale).astype(int).clip(0)
    for (left, top), (right, bottom) in zip(low.tolist(), high.tolist()):
        hidden[top:bottom, left:right] = 1
    size = (width, height)
    where = cv2.resize(hidden, size, interpolation=cv2.INTER_NEAREST)[..., None] > 0
    mosaic = cv2.resize(cells, size, interpolation=cv2.INTER_NEAREST)
    return np.where(where, mosaic, image)


def _foreground(output: CameraOutput, shape: tuple[int, int]) -> NDArray[np.uint8]:
    """Return which of (rows, columns) cells hold foreground, or all if it is not known."""
    detections = output.messages.get(Detections.TOPIC)
    foreground = output.messages.get(Foreground.TOPIC)
    is_blind = isinstance(detections, Detections) and detections.is_blind
    if isinstance(foreground, Foreground) and not is_blind and output.is_settled:
        if foreground.mask.size:
            grown = cv2.dilate(foreground.mask, np.ones((3, 3), np.uint8)).astype(np.float32)
            share = cv2.resize(grown, shape[::-1], interpolation=cv2.INTER_AREA)
            return (share > 0).astype(np.uint8)
        is_blind = True
    return np.full(shape, is_blind or not output.is_settled, np.uint8)
