"""Images, raw and compressed, with something wrong about them, by seed."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.fuzz.clouds import SIZES, octets_of
from mctrack_ros.codec import MessageClasses, header
from mctrack_ros.codec.encodings import ENCODINGS

WIDTH, HEIGHT = 32, 24
NAMES = ('', 'BGR8', 'bgr8 ', '32FC1', '8UC2', 'h264', 'jpeg; ', 'x' * 5000, 'a\nb', '%s{0}')
FORMATS = (
    'jpeg',
    'png',
    'bgr8; jpeg compressed bgr8',
    'rgb8; png compressed rgb8',
    'bayer_rggb8; png compressed bayer_rggb8',
    'bayer_x; jpeg compressed ',
    *NAMES,
)

Octets = NDArray[np.uint8]
Change = Callable[[Octets, np.random.Generator], Octets]


def malformed_raw(classes: MessageClasses, rng: np.random.Generator) -> Any:
    """Return a raw image with one to three of its parts changed."""
    name = str(rng.choice(list(ENCODINGS)))
    encoding = ENCODINGS[name]
    width, height = (2 * int(each) for each in rng.integers(1, 16, 2))
    step = width * encoding.channels * encoding.depth
    rows = height * encoding.rows[0] // encoding.rows[1]
    message = classes.image(
        header=header(classes, int(rng.integers(0, 2**60)), 'cam1'),
        height=height,
        width=width,
        encoding=name,
        is_bigendian=int(rng.integers(0, 2)),
        step=step,
        data=classes.octets(rng.integers(0, 256, rows * step, np.uint8)),
    )
    for part in rng.choice(list(_PARTS), int(rng.integers(1, 4)), replace=False):
        _PARTS[part](message, classes, rng)
    return message


def _size(name: str) -> Callable[[Any, MessageClasses, np.random.Generator], None]:
    def change(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
        near = max(getattr(message, name) + int(rng.integers(-2, 3)), 0)
        setattr(message, name, int(rng.choice([near, rng.choice(SIZES)])))

    return change


def _encoding(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.encoding = str(rng.choice([*ENCODINGS, *NAMES]))


def _order(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.is_bigendian = int(rng.integers(0, 256))


def _data(message: Any, classes: MessageClasses, rng: np.random.Generator) -> None:
    message.data = classes.octets(changed(octets_of(message), rng))


_PARTS: Mapping[str, Callable[[Any, MessageClasses, np.random.Generator], None]] = {
    'width': _size('width'),
    'height': _size('height'),
    'step': _size('step'),
    'encoding': _encoding,
    'order': _order,
    'data': _data,
}


def malformed_compressed(
    classes: MessageClasses, rng: np.random.Generator, size: tuple[int, int] = (WIDTH, HEIGHT)
) -> tuple[Any, bool]:
    """
    Return a compressed image with one to three changes, and whether it is but cut off.

    Parameters
    ----------
    classes : MessageClasses
        Of rclpy or of rosbags.
    rng : numpy.random.Generator
        Chooses what is changed.
    size : (int, int)
        Width and height that it had, px.

    """
    samples = sound_images(size)
    data = samples[rng.integers(len(samples))]
    is_cut = rng.random() < 0.1
    if is_cut:
        data = data[: rng.integers(0, data.size - 16)]
    else:
        for _ in range(int(rng.integers(1, 4))):
            data = changed(data, rng)
    message = classes.compressed_image(
        header=header(classes, int(rng.integers(0, 2**60)), 'cam1'),
        format=str(rng.choice(FORMATS)),
        data=classes.octets(data),
    )
    return message, is_cut


@cache
def sound_images(size: tuple[int, int]) -> tuple[Octets, ...]:
    """Return JPEG and PNG images of all kinds, of one width and height, px."""
    rng = np.random.default_rng(1)
    smooth = cv2.resize(rng.integers(0, 256, (6, 8, 4), np.uint8), size)
    deep = smooth.astype(np.uint16) * 257
    made = []
    for ending, image, options in (
        ('.jpg', smooth[..., :3], []),
        ('.jpg', smooth[..., 0], []),
        ('.jpg', smooth[..., :3], [cv2.IMWRITE_JPEG_PROGRESSIVE, 1]),
        ('.jpg', smooth[..., :3], [cv2.IMWRITE_JPEG_RST_INTERVAL, 2]),
        ('.png', smooth[..., :3], []),
        ('.png', smooth[..., 0], []),
        ('.png', smooth, []),
        ('.png', deep[..., :3], []),
        ('.png', deep[..., 0], []),
        ('.png', smooth[..., 0], [cv2.IMWRITE_PNG_BILEVEL, 1]),
    ):
        _, data = cv2.imencode(ending, image, options)
        made.append(np.asarray(data, np.uint8).reshape(-1))
    return tuple(made)


def changed(data: Octets, rng: np.random.Generator) -> Octets:
    """Return the bytes of an image with one change."""
    change = _CHANGES[rng.integers(len(_CHANGES))]
    return change(data, rng) if data.size > 32 else _noise(data, rng)


def _flips(data: Octets, rng: np.random.Generator) -> Octets:
    data, count = data.copy(), int(rng.integers(1, 20))
    bits = np.uint8(1) << rng.integers(0, 8, count, np.uint8)
    data[rng.integers(0, data.size, count)] ^= bits
    return data


def _head_flips(data: Octets, rng: np.random.Generator) -> Octets:
    return np.concatenate([_flips(data[:64], rng), data[64:]])


def _shorter(data: Octets, rng: np.random.Generator) -> Octets:
    return data[: rng.integers(0, data.size)]


def _longer(data: Octets, rng: np.random.Generator) -> Octets:
    return np.concatenate([data, rng.integers(0, 256, rng.integers(1, 3000), np.uint8)])


def _hole(data: Octets, rng: np.random.Generator) -> Octets:
    first, last = sorted(rng.integers(0, data.size, 2))
    return np.concatenate([data[:first], data[last:]])


def _twice(data: Octets, rng: np.random.Generator) -> Octets:
    first, last = sorted(rng.integers(0, data.size, 2))
    return np.concatenate([data[:last], data[first:]])


def _noise(data: Octets, rng: np.random.Generator) -> Octets:
    return rng.integers(0, 256, rng.integers(0, 3000), np.uint8)


def _noise_behind_head(data: Octets, rng: np.random.Generator) -> Octets:
    kept = int(rng.integers(2, min(data.size, 700)))
    return np.concatenate([data[:kept], _noise(data, rng)])


def _bomb(data: Octets, rng: np.random.Generator) -> Octets:
    """State another size, huge or not, with the right checksum."""
    width, height = (int(rng.choice([*SIZES, WIDTH, WIDTH + 1, 20000])) for _ in range(2))
    octets = data.tobytes()
    if octets[12:16] == b'IHDR':
        head = b'IHDR' + struct.pack('>II', width, height) + octets[24:29]
        checked = octets[:12] + head + struct.pack('>I', zlib.crc32(head)) + octets[33:]
        return np.frombuffer(checked, np.uint8)
    for marker in (b'\xff\xc0', b'\xff\xc2'):
        at = octets.find(marker)
        if at >= 0:
            size = struct.pack('>HH', height & 0xFFFF, width & 0xFFFF)
            return np.frombuffer(octets[: at + 5] + size + octets[at + 9 :], np.uint8)
    return data


_CHANGES: tuple[Change, ...] = (
    _flips,
    _head_flips,
    _shorter,
    _longer,
    _hole,
    _twice,
    _noise,
    _noise_behind_head,
    _bomb,
)
