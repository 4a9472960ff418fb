"""Pictures as `sensor_msgs/Image` and `CompressedImage` and back."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec.messages import CodecError, MessageClasses, header

try:
    import simplejpeg
except ImportError:  # not among ROS's own packages
    simplejpeg = None

_JPEG_START = b'\xff\xd8'

_CHANNELS = {'mono8': 1, 'bgr8': 3, 'rgb8': 3, 'bgra8': 4, 'rgba8': 4}
_TO_BGR = {
    'mono8': cv2.COLOR_GRAY2BGR,
    'rgb8': cv2.COLOR_RGB2BGR,
    'bgra8': cv2.COLOR_BGRA2BGR,
    'rgba8': cv2.COLOR_RGBA2BGR,
}


def image_from_message(message: Any) -> NDArray[np.uint8]:
    """
    Return the picture of a ``sensor_msgs/Image`` or ``CompressedImage``.

    Returns
    -------
    (height, width, 3) uint8 array
        Blue, green, red.

    Raises
    ------
    CodecError
        If the picture is empty, its size and its data disagree, or its encoding is not one of
        ``mono8``, ``bgr8``, ``rgb8``, ``bgra8``, ``rgba8``, JPEG or PNG.

    """
    data = np.frombuffer(message.data, np.uint8)
    if data.size == 0:
        raise CodecError('the image is empty')
    if not hasattr(message, 'encoding'):
        return _decompressed(data, str(message.format))
    if message.encoding not in _CHANNELS:
        raise CodecError(
            f'image encoding {message.encoding!r} is not known, expected one of '
            f'{", ".join(_CHANNELS)}'
        )
    height, width, channels = message.height, message.width, _CHANNELS[message.encoding]
    used = width * channels
    if height == 0 or width == 0 or message.step < used or data.size != message.step * height:
        raise CodecError(
            f'a {width} x {height} {message.encoding} image with step {message.step} holds '
            f'{data.size} bytes, expected {max(message.step, used) * height}'
        )
    picture = data.reshape(height, message.step)[:, :used].reshape(height, width, channels)
    if message.encoding == 'bgr8':
        return np.ascontiguousarray(picture)
    return np.asarray(cv2.cvtColor(picture, _TO_BGR[message.encoding]), np.uint8)


def image_message(
    image: NDArray[np.uint8], classes: MessageClasses, stamp_ns: int, frame_id: str
) -> Any:
    """Encode a (height, width, 3) BGR or (height, width) grey picture as ``sensor_msgs/Image``."""
    height, width = image.shape[:2]
    channels = 1 if image.ndim == 2 else 3
    return classes.image(
        header=header(classes, stamp_ns, frame_id),
        height=height,
        width=width,
        encoding='mono8' if channels == 1 else 'bgr8',
        is_bigendian=0,
        step=width * channels,
        data=classes.octets(np.ascontiguousarray(image).reshape(-1)),
    )


def compressed_message(
    jpeg: NDArray[np.uint8], classes: MessageClasses, stamp_ns: int, frame_id: str
) -> Any:
    """Wrap (n,) bytes of a JPEG picture as ``sensor_msgs/CompressedImage``."""
    return classes.compressed_image(
        header=header(classes, stamp_ns, frame_id), format='jpeg', data=classes.octets(jpeg)
    )


def jpeg_from_image(image: NDArray[np.uint8], quality: int = 90) -> NDArray[np.uint8]:
    """Compress a (height, width, 3) BGR picture; return the (n,) bytes of the JPEG."""
    done, jpeg = cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise CodecError(f'a picture of shape {image.shape} cannot be compressed')
    return np.asarray(jpeg, np.uint8).reshape(-1)


def _decompressed(data: NDArray[np.uint8], name: str) -> NDArray[np.uint8]:
    """Decompress; simplejpeg gives the same pixels as OpenCV in half the time."""
    if simplejpeg is not None and data[:2].tobytes() == _JPEG_START:
        try:
            return np.asarray(simplejpeg.decode_jpeg(data, 'BGR'))
        except ValueError as error:
            raise CodecError(f'{data.size} bytes of a JPEG image: {error}') from error
    picture = cv2.imdecode(data, cv2.IMREAD_COLOR)
    if picture is None:
        raise CodecError(f'{data.size} bytes of a {name!r} image cannot be decompressed')
    return np.asarray(picture, np.uint8)
