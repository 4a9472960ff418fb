"""Foreground that is a hole in the background: someone left who was taken for background."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter

Image = NDArray[np.uint8]
MARGIN = 3
KERNEL = np.ones((3, 3), np.uint8)


@dataclass(frozen=True)
class GhostConfig:
    """Parameters of `heal_ghosts`."""

    period_s: float = parameter(0.2, 'time between searches [s]', minimum=0.0)
    edge_ratio: float = parameter(
        1.25,
        "times that the background's edges along an outline exceed the picture's",
        minimum=1.0,
    )
    edge_difference: float = parameter(
        6.0, 'and by how much they do at least [grey levels]', minimum=0.0
    )


def heal_ghosts(
    model: Image, image: Image, mask: Image, box: NDArray[np.integer], config: GhostConfig
) -> NDArray[np.bool_]:
    """
    Find ghosts among persons and put the picture into the background there.

    Along a real object's outline the picture has edges, along a ghost's the background model.

    Parameters
    ----------
    model : (h, w, 3) uint8 array
        Background; changed in place where a ghost is.
    image : (h, w, 3) uint8 array
        Picture.
    mask : (h, w) uint8 array
        Foreground.
    box : (n, 4) int array
        Persons to look at: left, top, width, height in pixels of these pictures.
    config : GhostConfig
        Parameters.

    Returns
    -------
    (n,) bool array
        Which were ghosts.

    """
    found = np.zeros(len(box), np.bool_)
    for index, (left, top, width, height) in enumerate(box.tolist()):
        part = np.s_[
            max(top - MARGIN, 0) : top + height + MARGIN,
            max(left - MARGIN, 0) : left + width + MARGIN,
        ]
        outline = cv2.morphologyEx(mask[part], cv2.MORPH_GRADIENT, KERNEL)
        in_image, in_model = (_edges(picture[part], outline) for picture in (image, model))
        excess = in_model - in_image
        if in_model > config.edge_ratio * in_image and excess > config.edge_difference:
            hole = cv2.dilate(mask[part], KERNEL, iterations=MARGIN - 1)
            cv2.copyTo(image[part], hole, model[part])
            found[index] = True
    return found


def _edges(picture: Image, outline: cv2.typing.MatLike) -> float:
    """Return the mean gradient, grey levels, along an outline."""
    gradient = cv2.morphologyEx(picture, cv2.MORPH_GRADIENT, KERNEL)
    return float(sum(cv2.mean(gradient, outline)[:3]) / 3)
