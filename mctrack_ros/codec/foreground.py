"""Foreground masks as `sensor_msgs/CompressedImage` and back: PNG of one bit a pixel."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from mctrack_ros.codec.image_header import PNG_START, can_hold, is_whole, stated_size
from mctrack_ros.codec.messages import CodecError, MessageClasses, header, stamp_ns_of
from mctrack_ros.interfaces import Foreground

_BILEVEL = [cv2.IMWRITE_PNG_BILEVEL, 1, cv2.IMWRITE_PNG_COMPRESSION, 1]
"""The highest level takes five times as long for a third fewer bytes."""
_MOST_PIXELS = 1 << 22
"""Larger masks are refused before anything is allocated for them."""


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
