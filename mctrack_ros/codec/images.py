"""Images as `sensor_msgs/Image` and `CompressedImage` and back."""

from __future__ import annotations

from reprlib import repr as shortened
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec.encodings import encoding_of, image_from
from mctrack_ros.codec.image_header import JPEG_START, can_hold, is_whole, stated_size
from mctrack_ros.codec.messages import CodecError, MessageClasses, header

try:
    import simplejpeg
except ImportError:  # not among ROS's own packages
    simplejpeg = None

_MOST_PIXELS = 1 << 27
"""Images with more pixels are refused before anything is allocated for them."""


def image_from_message(message: Any, size: tuple[int, int] | None = None) -> NDArray[np.uint8]:
    """
    Return the image of a ``sensor_msgs/Image`` or ``CompressedImage``.

    Parameters
    ----------
    message : Image or CompressedImage
        Of any message classes.
    size : (int, int), optional
        The width and height that it must have, px; another one is refused undecoded.

    Returns
    -------
    (height, width, 3) uint8 array
        Blue, green, red.

    Raises
    ------
    CodecError
        If the image is empty or not of the size, its size and its data disagree, or its encoding
        is neither one of `ENCODINGS`, nor JPEG or PNG.

    """
    data = np.frombuffer(message.data, np.uint8)
    if data.size == 0:
        raise CodecError('the image is empty')
    if hasattr(message, 'encoding'):
        return _raw_image(message, data, size)
    return _decompressed(data, str(message.format), size)


def image_message(
    image: NDArray[np.uint8], classes: MessageClasses, stamp_ns: int, frame_id: str
) -> Any:
    """Encode a (height, width, 3) BGR or (height, width) grey image as ``sensor_msgs/Image``."""
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
    """Wrap (n,) bytes of a JPEG image as ``sensor_msgs/CompressedImage``."""
    return classes.compressed_image(
        header=header(classes, stamp_ns, frame_id), format='jpeg', data=classes.octets(jpeg)
    )


def jpeg_from_image(image: NDArray[np.uint8], quality: int = 90) -> NDArray[np.uint8]:
    """Compress a (height, width, 3) BGR image; return the (n,) bytes of the JPEG."""
    done, jpeg = cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise CodecError(f'an image of shape {image.shape} cannot be compressed')
    return np.asarray(jpeg, np.uint8).reshape(-1)


def _raw_image(
    message: Any, data: NDArray[np.uint8], size: tuple[int, int] | None
) -> NDArray[np.uint8]:
    """Return the image of an uncompressed message."""
    encoding, width, height = encoding_of(message.encoding), message.width, message.height
    _check_size((width, height), size)
    used = width * encoding.channels * encoding.depth
    per, of = encoding.rows
    rows = height * per // of
    if height == 0 or width == 0 or message.step < used or data.size != message.step * rows:
        raise CodecError(
            f'a {width} x {height} {message.encoding} image with step {message.step} holds '
            f'{data.size} bytes, expected {max(message.step, used) * rows}'
        )
    if width % encoding.even[0] or height % encoding.even[1]:
        raise CodecError(f'a {message.encoding} image cannot be {width} x {height}: expected even')
    values = data.reshape(rows, message.step)[:, :used]
    if encoding.depth == 2:
        order = '>u2' if message.is_bigendian else '<u2'
        values = np.ascontiguousarray(values).view(order).astype(np.uint16)
    return image_from(values.reshape(rows, width, encoding.channels), encoding)


def _decompressed(
    data: NDArray[np.uint8], name: str, size: tuple[int, int] | None
) -> NDArray[np.uint8]:
    """
    Decompress, by the format string of compressed_image_transport.

    That is ``<encoding>; <jpeg or png> compressed <encoding of the pixels in it>``, or the codec's
    name alone.
    """
    what = f'{data.size} bytes of a {shortened(name)} image'
    view = memoryview(data)
    stated = stated_size(view)
    if stated is None:
        raise CodecError(f'{what} cannot be decompressed: expected JPEG or PNG')
    _check_size(stated, size)
    if not can_hold(view, stated[0] * stated[1]) or not is_whole(view):
        raise CodecError(f'{what} cannot be decompressed: cut off or damaged')
    source, _, codec = (part.strip() for part in name.partition(';'))
    is_mosaic = source.startswith('bayer_') and not codec.endswith('compressed mono8')
    if view[:2] == JPEG_START and simplejpeg is not None:
        values: NDArray[Any] = _from_jpeg(data, is_mosaic)
    else:
        found = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
        if found is None:
            raise CodecError(f'{what} cannot be decompressed')
        values = np.asarray(found)
    image = _from_values(values, source if is_mosaic else '')
    return np.ascontiguousarray(image[..., ::-1]) if 'compressed rgb' in codec else image


def _from_jpeg(data: NDArray[np.uint8], may_be_grey: bool) -> NDArray[np.uint8]:
    """Decompress; simplejpeg gives the same pixels as OpenCV in half the time."""
    try:
        is_grey = may_be_grey and simplejpeg.decode_jpeg_header(data)[2] == 'Gray'
        return np.asarray(simplejpeg.decode_jpeg(data, 'GRAY' if is_grey else 'BGR'))
    except ValueError as error:
        raise CodecError(f'{data.size} bytes of a JPEG image: {error}') from error


def _from_values(values: NDArray[Any], mosaic: str) -> NDArray[np.uint8]:
    """Return the image of what OpenCV decompressed; of a mosaic, if it is one channel."""
    bits, channels = 8 * values.itemsize, values.shape[2] if values.ndim == 3 else 1
    name = f'{mosaic.rstrip("0123456789")}{bits}' if mosaic and channels == 1 else ''
    encoding = encoding_of(name or f'{bits}UC{channels}')
    return image_from(values.reshape(*values.shape[:2], channels), encoding)


def _check_size(found: tuple[int, int], expected: tuple[int, int] | None) -> None:
    """Refuse another size than the expected one, or one that nobody can mean."""
    width, height = found
    if expected is not None and found != tuple(expected):
        raise CodecError(f'image is {width} x {height}, expected {expected[0]} x {expected[1]}')
    if width * height > _MOST_PIXELS:
        raise CodecError(f'image is {width} x {height}, more than {_MOST_PIXELS} pixels')
