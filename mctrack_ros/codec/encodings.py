"""The pixel encodings of ``sensor_msgs/image_encodings`` as blue, green, red of 8 bits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from reprlib import repr as shortened
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec.messages import CodecError

Pixels = NDArray[Any]
_HALF_16 = 128  # rounds where 16 bits become 8
_STEPS_16 = 257  # 65535 / 255


@dataclass(frozen=True, slots=True)
class Encoding:
    """
    How the bytes of an encoding lie, and how they become blue, green, red.

    Attributes
    ----------
    depth : int
        Bytes of a value.
    channels : int
        Values of a pixel.
    convert : callable
        From the (rows, width, channels) values, of 8 or 16 bits, to an image of the same depth.
    rows : (int, int)
        Rows of data for how many rows of the image.
    even : (int, int)
        What width and height must be multiples of.

    """

    depth: int
    channels: int
    convert: Callable[[Pixels], Pixels]
    rows: tuple[int, int] = (1, 1)
    even: tuple[int, int] = (1, 1)


def _by_opencv(code: int) -> Callable[[Pixels], Pixels]:
    """Return a conversion of OpenCV."""
    return lambda values: cv2.cvtColor(values, code)


def _from_nv24(values: Pixels) -> Pixels:
    """
    Convert a plane of luma and one of blue and red chroma, both of full resolution.

    OpenCV has no conversion of its own: every pixel twice is UYVY.
    """
    height, width = values.shape[0] // 3, values.shape[1]
    luma, chroma = values[:height], values[height:].reshape(height, width, 2)
    packed = np.stack([chroma[..., 0], luma[..., 0], chroma[..., 1], luma[..., 0]], axis=2)
    doubled = cv2.cvtColor(packed.reshape(height, 2 * width, 2), cv2.COLOR_YUV2BGR_UYVY)
    return doubled[:, ::2]


# OpenCV names a mosaic by the second and third pixel of its second row.
_MOSAICS = {
    'rggb': cv2.COLOR_BayerBG2BGR,
    'bggr': cv2.COLOR_BayerRG2BGR,
    'gbrg': cv2.COLOR_BayerGR2BGR,
    'grbg': cv2.COLOR_BayerGB2BGR,
}
_COLOURS: dict[str, tuple[int, Callable[[Pixels], Pixels]]] = {
    'mono': (1, _by_opencv(cv2.COLOR_GRAY2BGR)),
    'bgr': (3, np.ascontiguousarray),
    'rgb': (3, _by_opencv(cv2.COLOR_RGB2BGR)),
    'bgra': (4, _by_opencv(cv2.COLOR_BGRA2BGR)),
    'rgba': (4, _by_opencv(cv2.COLOR_RGBA2BGR)),
}
_UNNAMED = {1: 'mono', 3: 'bgr', 4: 'bgra'}
_UYVY = Encoding(1, 2, _by_opencv(cv2.COLOR_YUV2BGR_UYVY), even=(2, 1))
_YUYV = Encoding(1, 2, _by_opencv(cv2.COLOR_YUV2BGR_YUY2), even=(2, 1))

ENCODINGS: dict[str, Encoding] = {
    f'{name}{8 * depth}': Encoding(depth, channels, convert)
    for depth in (1, 2)
    for name, (channels, convert) in _COLOURS.items()
}
ENCODINGS |= {
    f'{8 * depth}UC{channels}': ENCODINGS[f'{name}{8 * depth}']
    for depth in (1, 2)
    for channels, name in _UNNAMED.items()
}
ENCODINGS |= {
    f'bayer_{mosaic}{8 * depth}': Encoding(depth, 1, _by_opencv(code))
    for depth in (1, 2)
    for mosaic, code in _MOSAICS.items()
}
ENCODINGS |= {
    'yuv422': _UYVY,
    'uyvy': _UYVY,
    'yuv422_yuy2': _YUYV,
    'yuyv': _YUYV,
    'nv21': Encoding(1, 1, _by_opencv(cv2.COLOR_YUV2BGR_NV21), rows=(3, 2), even=(2, 2)),
    'nv24': Encoding(1, 1, _from_nv24, rows=(3, 1)),
}
"""By their names in ROS. Numbers of channels without a name are grey, BGR and BGRA."""


def encoding_of(name: str) -> Encoding:
    """
    Return an encoding by its name.

    Raises
    ------
    CodecError
        If it is none that holds an image.

    """
    found = ENCODINGS.get(name)
    if found is None:
        raise CodecError(
            f'image encoding {shortened(name)} is not known, '
            f'expected one of {", ".join(ENCODINGS)}'
        )
    return found


def image_from(values: Pixels, encoding: Encoding) -> NDArray[np.uint8]:
    """
    Return the (height, width, 3) image, blue, green, red, of (rows, width, channels) values.

    16 bits become 8 over their whole range, 65535 as 255, as cv_bridge does it: a camera that uses
    only the lower 12 of them gives a dark image.
    """
    image = encoding.convert(values)
    if image.dtype == np.uint16:
        image = (image.astype(np.uint32) + _HALF_16) // _STEPS_16
    return np.ascontiguousarray(image, np.uint8)
