"""Boxes of other people's detectors: clouds, or `vision_msgs/Detection2DArray` of version 4."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from mctrack_ros.codec import CodecError, fields_of_cloud, stamp_ns_of
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Detections
from mctrack_ros.perception import boxes_to_detections
from mctrack_ros.recording.tables.class_names import CLASS_NAMES
from mctrack_ros.recording.tables.vision_messages import ARRAY, box_of


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


def detections_of_cloud(message: Any, mapping: GroundMapping) -> Detections:
    """
    Put the boxes of a `PointCloud2` on the ground, with covariance.

    Its fields are those of detections: ``box``, ``score``, and, where the detector knows them,
    ``class_id`` (else a person) and ``local_id``.

    Parameters
    ----------
    message : sensor_msgs/PointCloud2
        Boxes in the camera's images, px.
    mapping : GroundMapping
        Of the camera.

    Raises
    ------
    CodecError, ValueError
        If the cloud cannot be read or lacks boxes or scores, a box has no size, or a score is
        beyond 0 to 1.

    """
    fields = fields_of_cloud(message)
    for name in ('box', 'score'):
        if name not in fields:
            raise CodecError(f'a cloud of boxes lacks the field {name!r}')
    for name in ('class_id', 'local_id'):
        if name in fields and fields[name].dtype.kind not in 'iu':
            raise CodecError(f'field {name!r} of a cloud of boxes holds no whole numbers')
    return boxes_to_detections(
        fields['box'],
        fields['score'],
        mapping,
        stamp_ns_of(message),
        class_id=fields.get('class_id'),
        local_id=fields.get('local_id'),
    )


BOXES: dict[str, tuple[str, Callable[[Any, GroundMapping], Detections]]] = {
    'Detection2DArray': (ARRAY, detections_of),
    'PointCloud2': (Detections.ROS_TYPE, detections_of_cloud),
}
"""The type of each message of boxes, and what puts them on the ground."""
