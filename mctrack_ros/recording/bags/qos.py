"""Quality of service as bags state it, and what the graph's own topics offer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import yaml
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2.metadata import dump_qos_v9

from mctrack_ros.interfaces import Candidates, Decisions, Events, Ticks

FOREVER = QosTime(9223372036, 854775807)
"""A duration without end, as rosbag2 writes it."""


def reliable(depth: int, *, latched: bool = False) -> Qos:
    """Return what a reliable publisher that keeps its last messages offers."""
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=depth,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=FOREVER,
        lifespan=FOREVER,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=FOREVER,
        avoid_ros_namespace_conventions=False,
    )


USUAL = reliable(10)
"""What topics offer that are in neither table."""

OF_TYPES: Mapping[str, Qos] = {
    'std_msgs/msg/String': reliable(1, latched=True),
    'sensor_msgs/msg/Image': reliable(8),
    'sensor_msgs/msg/CompressedImage': reliable(8),
}
"""What the nodes offer, by message type (see docs/reference/topics.md)."""

OF_ROWS: Mapping[type[Any], Qos] = dict.fromkeys(
    (Events, Ticks, Candidates, Decisions), reliable(100)
)
"""What the nodes offer for clouds of rows."""


def stated(offered: Sequence[Qos]) -> str:
    """Return what publishers offer as the files of a bag state it."""
    return yaml.safe_dump(dump_qos_v9(list(offered)), sort_keys=False).strip() if offered else ''
