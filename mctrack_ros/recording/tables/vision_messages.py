"""`vision_msgs/Detection2DArray` in bags: the detections of other people's nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mctrack_ros.codec import stamp_ns_of
from mctrack_ros.recording.bags.bag import BagReader
from mctrack_ros.recording.errors import BagError
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tables.sightings import Sightings, numbered

ARRAY = 'vision_msgs/msg/Detection2DArray'
_DEFINITIONS = {
    ARRAY: 'std_msgs/Header header\nvision_msgs/Detection2D[] detections',
    'vision_msgs/msg/Detection2D': 'std_msgs/Header header\n'
    'vision_msgs/ObjectHypothesisWithPose[] results\nvision_msgs/BoundingBox2D bbox\nstring id',
    'vision_msgs/msg/ObjectHypothesisWithPose': 'vision_msgs/ObjectHypothesis hypothesis\n'
    'geometry_msgs/PoseWithCovariance pose',
    'vision_msgs/msg/ObjectHypothesis': 'string class_id\nfloat64 score',
    'vision_msgs/msg/BoundingBox2D': 'vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y',
    'vision_msgs/msg/Pose2D': 'vision_msgs/Point2D position\nfloat64 theta',
    'vision_msgs/msg/Point2D': 'float64 x\nfloat64 y',
}
"""Of version 4.1 (Humble to Jazzy). In 4.0 the centre is a geometry_msgs/Pose2D: x, y and theta as
well, so its bytes are the same."""


def read_detection_arrays(path: str | Path, camera: str, topic: str = '') -> Sightings:
    """
    Read what a detector published of one camera.

    Parameters
    ----------
    path : str or Path
        The bag.
    camera : str
        Name of the camera.
    topic : str
        Unless given, the one of the type that there is, or that has the camera in its name.

    Raises
    ------
    BagError, TableError
        If the bag cannot be read, or a message of it cannot be used; says which.

    """
    types = get_typestore(Stores.ROS2_JAZZY)
    for name, text in _DEFINITIONS.items():
        types.register(get_types_from_msg(text, name))
    stamps: list[int] = []
    rows: list[tuple[int, list[float], float, str, str]] = []
    with BagReader(path) as reader:
        topic = topic or _topic_of(reader, camera)
        if reader.topics.get(topic) != ARRAY:
            raise BagError(f'{path} has no {ARRAY} on {topic}')
        for number, (_, _, data, _) in enumerate(reader.serialized([topic]), 1):
            where = f'{path}, message {number} on {topic}'
            try:
                message: Any = types.deserialize_cdr(data, ARRAY)
            except Exception as error:
                raise TableError(
                    f'{where} is no {ARRAY} of vision_msgs 4 (Humble, Jazzy): {error}'
                ) from error
            stamp = stamp_ns_of(message)
            if stamp <= (stamps[-1] if stamps else 0):
                before = f'{stamps[-1] * 1e-9:.3f} s before it' if stamps else 'more than 0'
                raise TableError(f'{where} has the stamp {stamp * 1e-9:.3f} s, after {before}')
            rows += [(len(stamps), *box_of(one, where)) for one in message.detections]
            stamps.append(stamp)
    if not stamps:
        raise BagError(f'{path} has no messages on {topic}')
    image, box, score, label, names = zip(*rows) if rows else ((),) * 5
    count = len(rows)
    return Sightings(
        stamp_ns=np.array(stamps, np.int64),
        image=np.array(image, np.int64),
        box=np.array(box, np.float64).reshape(-1, 4),
        position=np.full((count, 2), np.nan),
        sigma=np.full(count, np.nan),
        score=np.array(score, np.float64),
        label=np.array(label, np.str_),
        local_id=numbered(list(names)),
    )


def _topic_of(reader: BagReader, camera: str) -> str:
    found = sorted(topic for topic, kind in reader.topics.items() if kind == ARRAY)
    named = [topic for topic in found if camera in topic.split('/')]
    if len(named or found) != 1:
        raise BagError(
            f'{reader.path}: {len(found)} topics hold {ARRAY} ({", ".join(found) or "none"}): '
            f'name that of {camera} behind the bag, {camera}={reader.path}:/TOPIC'
        )
    return (named or found)[0]


def box_of(detection: Any, where: str) -> tuple[list[float], float, str, str]:
    """
    Return box, score, class and id of a `Detection2D`; of a turned box what encloses it.

    Parameters
    ----------
    detection : vision_msgs/Detection2D
        Of version 4, whoever decoded it.
    where : str
        What it is of, for messages.

    Raises
    ------
    TableError
        If it has no result, no size, or a score beyond 0 to 1.

    """
    if not detection.results:
        raise TableError(f'{where}: a detection has no result, so no score')
    best = max((result.hypothesis for result in detection.results), key=lambda one: one.score)
    centre, width, height = detection.bbox.center, detection.bbox.size_x, detection.bbox.size_y
    across, down = abs(np.cos(centre.theta)), abs(np.sin(centre.theta))
    size = across * width + down * height, down * width + across * height
    middle = getattr(centre, 'position', centre)  # version 4.0 has x and y in the centre itself
    box = [middle.x - size[0] / 2, middle.y - size[1] / 2, *size]
    if not np.isfinite([*box, best.score]).all() or width <= 0 or height <= 0:
        raise TableError(f'{where}: a box is {width:g} x {height:g} px, expected more than 0')
    if not 0 <= best.score <= 1:
        raise TableError(f'{where}: a score is {best.score:g}, expected 0 to 1')
    return [float(value) for value in box], float(best.score), best.class_id, detection.id
