"""A colour for every track, the same in every image, page and scene."""

from __future__ import annotations

import colorsys

_GOLDEN = 0.6180339887  # golden ratio: consecutive ids get hues far apart


def track_colour(track_id: int) -> tuple[int, int, int]:
    """Return red, green and blue of a track, 0 to 255; ids close by differ much in hue."""
    value = 0.95 - 0.2 * (track_id // 5 % 2)
    red, green, blue = colorsys.hsv_to_rgb(track_id * _GOLDEN % 1.0, 0.72, value)
    return round(255 * red), round(255 * green), round(255 * blue)
