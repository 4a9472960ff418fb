"""The targets that fusion predicts in an image: their boxes, and the colours seen there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import TEMPLATE_SIZE, ClassCode, Detections, Feedback
from mctrack_ros.perception.blobs.frame import Frame
from mctrack_ros.tracking.appearance import colour_templates

Floats = NDArray[np.float64]

LEAST_COLOURED = 0.25
"""Share of a target's box that must be its own foreground for its colours to be told."""


def targets_in_view(
    feedback: Feedback,
    stamp_ns: int,
    frame: Frame,
    mapping: GroundMapping,
    person: tuple[float, float],
) -> Detections:
    """
    Return a detection of each target in view, where it is predicted, near ones first.

    Who stands nearer hides who is behind: his pixels do not count for others.

    Parameters
    ----------
    feedback : Feedback
        The targets.
    stamp_ns : int
        Of the image, ns.
    frame : Frame
        The image with its foreground.
    mapping : GroundMapping
        Of the camera.
    person : (float, float)
        Height and width of a person, m.

    """
    place = feedback.places(stamp_ns)
    box = _boxes(mapping, place, person)
    size = np.array(mapping.image_size)
    with np.errstate(invalid='ignore'):
        low, high = np.clip(box[:, :2], 0, size), np.clip(box[:, :2] + box[:, 2:], 0, size)
        seen = np.asarray((high - low > 1).all(axis=1))
    distance = np.linalg.norm(place - mapping.camera_position[:2], axis=1)
    order = np.argsort(distance, kind='stable')
    order = order[seen[order]]
    scale = np.tile(np.divide(frame.image.shape[1::-1], size), 2)
    small = np.rint(np.hstack([low, high])[order] * scale).astype(np.int64)
    small[:, 2:] -= small[:, :2]
    left, template = frame.objects.copy(), np.zeros((len(order), TEMPLATE_SIZE))
    share = np.zeros(len(order))
    for row, own in enumerate(small):
        x, y, width, height = own.tolist()
        window = left[y : y + height, x : x + width]
        share[row] = np.count_nonzero(window) / max(window.size, 1)
        if share[row] >= LEAST_COLOURED:
            template[row] = colour_templates(frame.image, left, own[None], frame.balance)[0]
        window[:] = 0
    return Detections.build(
        stamp_ns,
        position=np.column_stack([place[order], np.zeros(len(order))]),
        covariance=feedback.covariance[order][:, :2, :2],
        box=np.hstack([low, high - low])[order],
        area=share * np.prod((high - low)[order], axis=1),
        score=share,
        template=template,
        track_id=feedback.track_id[order],
        truncated=((low == 0) | (high == size)).any(axis=1)[order],
        class_id=np.full(len(order), ClassCode.PERSON),
    )


def _boxes(mapping: GroundMapping, place: Floats, person: tuple[float, float]) -> Floats:
    """Return the (n, 4) boxes of people at places, left, top, width, height, px."""
    height, width = person
    foot, head = mapping.image_from_ground(place), mapping.image_from_ground(place, height)
    across = mapping.width_px(place, width)
    top = np.minimum(foot[:, 1], head[:, 1])
    middle = (foot[:, 0] + head[:, 0]) / 2
    tall = np.abs(foot[:, 1] - head[:, 1])
    return np.column_stack([middle - across / 2, top, across, tall])
