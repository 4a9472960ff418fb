"""What a compressed image says of itself, read without decompressing it."""

from __future__ import annotations

import zlib

JPEG_START = b'\xff\xd8'
PNG_START = b'\x89PNG\r\n\x1a\n'
_JPEG_SCAN, _JPEG_END = b'\xff\xda', b'\xff\xd9'
_PNG_SIZE = 24
_JPEG_PIXELS, _PNG_PIXELS = 512, 8 * 1032
"""Most pixels in a byte: a bit for a block of 64; bits of one colour, which deflate packs so."""
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers that begin a frame: the others of these are tables."""
_ALONE = frozenset({0x01, *range(0xD0, 0xD8)})
"""Markers that nothing follows."""


def stated_size(data: memoryview) -> tuple[int, int] | None:
    """
    Return the width and height that a JPEG or PNG states, px; None: it is neither.

    Parameters
    ----------
    data : memoryview
        Its bytes.

    """
    if data[:8] == PNG_START and bytes(data[12:16]) == b'IHDR' and len(data) >= _PNG_SIZE:
        return int.from_bytes(data[16:20]), int.from_bytes(data[20:24])
    return _jpeg_size(data) if data[:2] == JPEG_START else None


def is_whole(data: memoryview) -> bool:
    """
    Tell whether a JPEG or PNG was neither cut off nor, if it is a PNG, changed.

    Decoders find most of this, too, but some give what they have, and write to standard error.

    Parameters
    ----------
    data : memoryview
        Its bytes.

    """
    octets = bytes(data)
    if octets[:8] != PNG_START:
        return octets.rfind(_JPEG_END) > octets.rfind(_JPEG_SCAN) > 0
    at = 8
    while at + 12 <= len(octets):
        end = at + 8 + int.from_bytes(octets[at : at + 4])
        if zlib.crc32(octets[at + 4 : end]) != int.from_bytes(octets[end : end + 4]):
            return False
        if octets[at + 4 : at + 8] == b'IEND':
            return True
        at = end + 4
    return False


def can_hold(data: memoryview, pixels: int) -> bool:
    """Tell whether so many pixels, and not none, can be in the bytes of a JPEG or PNG."""
    return 0 < pixels <= len(data) * (_JPEG_PIXELS if data[:2] == JPEG_START else _PNG_PIXELS)


def _jpeg_size(data: memoryview) -> tuple[int, int] | None:
    """Go from marker to marker until one begins the frame."""
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker in _FRAMES:
            return int.from_bytes(data[at + 7 : at + 9]), int.from_bytes(data[at + 5 : at + 7])
        if marker == 0xFF:
            at += 1
        elif marker in _ALONE:
            at += 2
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4])
    return None
