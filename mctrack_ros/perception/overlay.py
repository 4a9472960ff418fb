"""A picture of what a camera node sees: boxes, ids, groups, predictions."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import Detections

Image = NDArray[np.uint8]

SINGLE = (80, 255, 80)
TENTATIVE = (160, 160, 160)
GROUP = (60, 160, 255)
PREDICTED = (255, 200, 0)


def draw_overlay(image: Image, detections: Detections, predicted: NDArray[np.floating]) -> Image:
    """
    Draw detections and predicted boxes over a picture.

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        The picture; it is not changed.
    detections : Detections
        Green with local and global id; groups orange with their members; grey what is not yet
        believed.
    predicted : (n, 4) array
        Predicted boxes of the camera's own tracks, px; blue, thin.

    Returns
    -------
    (h, w, 3) uint8 array
        The drawing.

    """
    canvas = image.copy()
    for box in predicted[np.isfinite(predicted).all(axis=1)]:
        _rectangle(canvas, box, PREDICTED, 1)
    for row, box in enumerate(detections.box):
        count = int(detections.member_count[row])
        if count != 1:
            ids = [str(number) for number in detections.members[row] if number]
            colour, text = GROUP, f'{count or "?"}: {" ".join(ids)}'
        else:
            text = f'{detections.local_id[row]}'
            if detections.track_id[row]:
                text += f'={detections.track_id[row]}'
            colour = SINGLE if detections.score[row] >= 1 else TENTATIVE
        _rectangle(canvas, box, colour, 2 if count != 1 else 1)
        corner = (int(box[0]), max(int(box[1]) - 3, 8))
        cv2.putText(canvas, text, corner, cv2.FONT_HERSHEY_SIMPLEX, 0.35, colour, 1, cv2.LINE_AA)
    return canvas


def _rectangle(
    canvas: Image, box: NDArray[np.floating], colour: tuple[int, int, int], thickness: int
) -> None:
    left, top, width, height = np.rint(box).astype(int).tolist()
    cv2.rectangle(canvas, (left, top), (left + width - 1, top + height - 1), colour, thickness)
