"""The message classes of rclpy, for the codec, and how a type's name leads to its class."""

from __future__ import annotations

import array
import importlib
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from sensor_msgs.msg import CompressedImage, Image, PointCloud2, PointField
from std_msgs.msg import Header

from mctrack_ros.codec import MessageClasses


def _octets(data: NDArray[np.uint8]) -> array.array[int]:
    """Return bytes in the container that rclpy stores without a look at each of them."""
    octets = array.array('B')
    octets.frombytes(data.tobytes())
    return octets


RCLPY_CLASSES = MessageClasses(
    cloud=PointCloud2,
    field=PointField,
    header=Header,
    time=Time,
    image=Image,
    compressed_image=CompressedImage,
    octets=_octets,
)


def message_class(kind: str) -> Any:
    """
    Return the class of a message type such as ``std_msgs/msg/String``.

    Raises
    ------
    ValueError
        If its package is not installed or has no such message.

    """
    try:
        package, folder, name = kind.split('/')
        return getattr(importlib.import_module(f'{package}.{folder}'), name)
    except (ValueError, ImportError, AttributeError) as error:
        raise ValueError(f'message type {kind!r} is not installed') from error


def starts_with_header(message: Any) -> bool:
    """Tell whether the first field of a message class is a ``std_msgs/Header``."""
    fields = message.get_fields_and_field_types()
    return next(iter(fields.values()), '') == 'std_msgs/Header'
