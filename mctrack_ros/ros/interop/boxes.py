"""`vision_msgs/Detection2DArray` of version 4: the boxes of other people's detectors."""

from __future__ import annotations

from typing import Any

import numpy as np

from mctrack_ros.codec import stamp_ns_of
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Detections
from mctrack_ros.perception import boxes_to_detections
from mctrack_ros.recording.tables.class_names import CLASS_NAMES
from mctrack_ros.recording.tables.vision_messages import ARRAY, box_of

BOXES_TYPE = ARRAY


def detections_of(message: Any, mapping: GroundMapping) -> Detections:
    """
    Put the boxes of a `Detection2DArray` on the ground, with covariance.

    The best hypothesis of each counts; classes that this package does not know are left out, and a
    box without a class is a person.

    Parameters
    ----------
    message : vision_msgs/Detection2DArray
        Boxes in the camera's images, px.
    mapping : GroundMapping
        Of the camera.

    Raises
    ------
    TableError, ValueError
        If a box has no result, no size, or a score beyond 0 to 1.

    """
    boxes = [box_of(one, f'detection {index}') for index, one in enumerate(message.detections)]
    codes = [CLASS_NAMES.get(label.lower() or 'person') for _, _, label, _ in boxes]
    known = [(*one[:2], int(code)) for one, code in zip(boxes, codes) if code is not None]
    box, score, code = zip(*known) if known else ((), (), ())
    rows = np.array(box, np.float64).reshape(-1, 4)
    return boxes_to_detections(
        rows, np.array(score, np.float64), mapping, stamp_ns_of(message), class_id=code
    )
