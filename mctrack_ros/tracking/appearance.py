"""Appearance templates: histograms of hue and brightness, and their distance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, FLOATS_2D, INTS_2D, compiled, inner
from mctrack_ros.interfaces import TEMPLATE_SIZE


class Palette(NamedTuple):
    """
    What a template counts: first the hues, then the levels of brightness.

    A pixel counts for its hue as far as it has colour, and for its brightness by the rest.

    Attributes
    ----------
    hues, greys : int
        Bins of hue, and of brightness.
    hue_share : float
        Of a wholly saturated pixel, what counts for its hue; 0 to 1.

    """

    hues: int
    greys: int
    hue_share: float


MIXED = Palette(12, 36, 0.5)
PALETTES = {
    'mixed': MIXED,
    'hue': Palette(16, 1, 1.0),
}
"""By name: `mixed` separates people best, `hue` where cameras are not exposed alike."""

PALETTE = types.NamedTuple([types.i8, types.i8, types.f8], Palette)


def colour_templates(
    image: NDArray[np.uint8],
    mask: NDArray[np.uint8],
    box: NDArray[np.integer],
    palette: Palette = MIXED,
) -> NDArray[np.float64]:
    """
    Count the colours of the foreground in boxes.

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        BGR image.
    mask : (h, w) uint8 array
        Not zero where a pixel counts.
    box : (n, 4) int array
        Left, top, width, height, px.
    palette : Palette
        What is counted.

    Returns
    -------
    (n, 48) float64 array
        Each sums to 1; what the palette does not use is 0. Zero where nothing counts.

    """
    image, mask = np.ascontiguousarray(image), np.ascontiguousarray(mask)
    counted: NDArray[np.float64] = _count(
        image, mask, np.ascontiguousarray(box, np.int64), palette
    )
    return counted


def bhattacharyya_distance(
    first: NDArray[np.floating], second: NDArray[np.floating]
) -> NDArray[np.float64]:
    """
    Return the (n, m) distances of (n, 48) and (m, 48) templates: 0 the same, 1 nothing in common.

    An empty template carries nothing: its distance to all is one half.
    """
    one, other = _roots(first), _roots(second)
    return np.asarray(_distances(one @ other.T, one, other))


def squared_hellinger(
    first: NDArray[np.floating], second: NDArray[np.floating]
) -> NDArray[np.float64]:
    """Return the (n, m) squares of the Bhattacharyya distances, 1 where a template is empty."""
    shared = _roots(first) @ _roots(second).T
    return np.asarray(np.minimum(np.maximum(1 - shared, 0.0), 1.0))


def _roots(template: NDArray[np.floating]) -> NDArray[np.float64]:
    return np.asarray(np.sqrt(np.maximum(template, 0)), np.float64)


@inner
def is_empty(template: NDArray[np.float64]) -> bool:
    """Tell whether a template, (48,), counts nothing, in compiled functions."""
    bin = 0
    while bin < len(template) and template[bin] == 0.0:
        bin += 1
    return bin == len(template)


@compiled(types.f8[:, ::1](FLOATS_2D, FLOATS_2D, FLOATS_2D))
def _distances(
    shared: NDArray[np.float64], first: NDArray[np.float64], second: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the Bhattacharyya distances from products of (n, 48) and (m, 48) roots."""
    distance, empty = np.empty(shared.shape), np.empty(len(second), np.bool_)
    for column in range(len(second)):
        empty[column] = is_empty(second[column])
    for row in range(len(first)):
        blank = is_empty(first[row])
        for column in range(len(second)):
            distance[row, column] = np.sqrt(min(max(1.0 - shared[row, column], 0.0), 1.0))
            if blank or empty[column]:
                distance[row, column] = 0.5
    return distance


@inner
def colour_bins(palette: Palette, blue: float, green: float, red: float) -> tuple[int, int, float]:
    """
    Return a colour's bins of hue and of brightness, and the weight of the former.

    Parameters
    ----------
    palette : Palette
        What is counted.
    blue, green, red : float
        0 to 255.

    """
    value = max(blue, green, red)
    spread = value - min(blue, green, red)
    luma = 0.114 * blue + 0.587 * green + 0.299 * red
    grey = palette.hues + min(int(luma * palette.greys / 256.0), palette.greys - 1)
    if spread == 0.0:
        return 0, grey, 0.0
    if value == red:
        sixth = (green - blue) / spread
    elif value == green:
        sixth = 2.0 + (blue - red) / spread
    else:
        sixth = 4.0 + (red - green) / spread
    hue = int(np.floor(sixth * (palette.hues / 6.0))) % palette.hues
    return hue, grey, palette.hue_share * spread / value


@compiled(types.f8[:, ::1](BYTES_3D, BYTES_2D, INTS_2D, PALETTE))
def _count(
    image: NDArray[np.uint8], mask: NDArray[np.uint8], box: NDArray[np.int64], palette: Palette
) -> NDArray[np.float64]:
    """Add up every box pixel by pixel."""
    templates = np.zeros((len(box), TEMPLATE_SIZE))
    shades = np.empty(256, np.int64)
    for level in range(256):
        shades[level] = colour_bins(palette, float(level), float(level), float(level))[1]
    for index in range(len(box)):
        left, top, width, height = box[index]
        template, count = templates[index], 0
        for row in range(max(top, 0), min(top + height, mask.shape[0])):
            for column in range(max(left, 0), min(left + width, mask.shape[1])):
                if not mask[row, column]:
                    continue
                count += 1
                pixel = image[row, column]
                blue, green, red = pixel[0], pixel[1], pixel[2]
                if blue == green == red:  # as every pixel of a grey image is
                    template[shades[blue]] += 1.0
                    continue
                hue, grey, weight = colour_bins(palette, float(blue), float(green), float(red))
                template[hue] += weight
                template[grey] += 1.0 - weight
        template /= max(count, 1)
    return templates
