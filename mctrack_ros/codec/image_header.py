"""The size that a compressed image states, read without decompressing it."""

from __future__ import annotations

JPEG_START = b'\xff\xd8'
PNG_START = b'\x89PNG\r\n\x1a\n'
_PNG_SIZE = 24
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
