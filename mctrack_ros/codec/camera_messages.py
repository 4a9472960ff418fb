"""Messages of camera nodes of every kind: encoded as ROS messages, decoded back."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from mctrack_ros.codec.clouds import cloud_from_rows, rows_from_cloud
from mctrack_ros.codec.image_header import PNG_START, can_hold, is_whole, stated_size
from mctrack_ros.codec.messages import CodecError, MessageClasses, header, stamp_ns_of
from mctrack_ros.interfaces import Foreground, Message

_BILEVEL = [cv2.IMWRITE_PNG_BILEVEL, 1, cv2.IMWRITE_PNG_COMPRESSION, 1]
"""The highest level takes five times as long for a third fewer bytes."""
_MOST_PIXELS = 1 << 22
"""Larger masks are refused before anything is allocated for them."""


def ros_from_message(message: Message, classes: MessageClasses, frame_id: str) -> Any:
    """Encode rows as a cloud, a mask as a PNG."""
    if isinstance(message, Foreground):
        return png_from_foreground(message, classes, frame_id)
    return cloud_from_rows(message, classes, frame_id)  # type: ignore[arg-type]


def message_from_ros(ros: Any, kind: type[Any]) -> Any:
    """
    Decode a message of one of the kinds that camera nodes publish.

    Raises
    ------
    CodecError
        If it does not hold that.

    """
    return foreground_from_png(ros) if kind is Foreground else rows_from_cloud(ros, kind)


def png_from_foreground(foreground: Foreground, classes: MessageClasses, frame_id: str) -> Any:
    """Encode a mask as ``sensor_msgs/CompressedImage``; without data where nothing is known."""
    data = np.zeros(0, np.uint8)
    if foreground.mask.size:
        done, png = cv2.imencode('.png', foreground.mask, _BILEVEL)
        if not done:
            raise CodecError(f'a mask of shape {foreground.mask.shape} cannot be compressed')
        data = np.asarray(png, np.uint8).reshape(-1)
    return classes.compressed_image(
        header=header(classes, foreground.stamp_ns, frame_id),
        format='png',
        data=classes.octets(data),
    )


def foreground_from_png(message: Any) -> Foreground:
    """
    Decode a mask; pixels of any grey but black are foreground.

    Raises
    ------
    CodecError
        If the data is no PNG, or a larger one than any mask.

    """
    data = np.frombuffer(message.data, np.uint8)
    if not data.size:
        return Foreground.build(stamp_ns_of(message))
    view = memoryview(data)
    width, height = (view[:8] == PNG_START and stated_size(view)) or (0, 0)
    is_small = 0 < width * height <= _MOST_PIXELS and can_hold(view, width * height)
    mask = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE) if is_small and is_whole(view) else None
    if mask is None:
        raise CodecError(f'{data.size} bytes of a mask cannot be decompressed: expected a PNG')
    return Foreground(stamp_ns_of(message), np.where(mask > 0, np.uint8(255), np.uint8(0)))
