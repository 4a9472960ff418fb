"""What every message of the graph is made with: the classes of a ROS implementation, headers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


class CodecError(ValueError):
    """A message that does not hold what it should."""


@dataclass(frozen=True, slots=True)
class MessageClasses:
    """
    The message classes of one ROS implementation.

    Attributes
    ----------
    cloud, field, header, time, image, compressed_image : callable
        ``sensor_msgs/PointCloud2``, ``PointField``, ``std_msgs/Header``,
        ``builtin_interfaces/Time``, ``sensor_msgs/Image`` and ``CompressedImage``.
    octets : callable
        Turns a (n,) uint8 array into what the implementation stores fastest in ``uint8[]``.

    """

    cloud: Callable[..., Any]
    field: Callable[..., Any]
    header: Callable[..., Any]
    time: Callable[..., Any]
    image: Callable[..., Any]
    compressed_image: Callable[..., Any]
    octets: Callable[[NDArray[np.uint8]], Any]


def stamp_ns_of(message: Any) -> int:
    """Return the header's stamp in ns."""
    stamp = message.header.stamp
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def header(classes: MessageClasses, stamp_ns: int, frame_id: str) -> Any:
    """Return a ``std_msgs/Header``."""
    seconds, nanoseconds = divmod(int(stamp_ns), 1_000_000_000)
    stamp = classes.time(sec=seconds, nanosec=nanoseconds)
    return classes.header(stamp=stamp, frame_id=frame_id)
