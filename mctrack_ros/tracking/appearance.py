"""Appearance templates: hues and brightness of both halves of a body, and their distance."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    BYTES_2D,
    BYTES_3D,
    FLOATS_1D,
    FLOATS_2D,
    INTS_2D,
    compiled,
    inner,
)
from mctrack_ros.interfaces import TEMPLATE_SIZE

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]

HUES, GREYS = 12, 12
"""Bins of hue and of brightness."""
HALF = TEMPLATE_SIZE // 2
"""Bins of the upper half of a body, which come first, and of the lower. Where they meet a pixel
counts in both."""
WAIST = 0.3
"""Share of the height over which the upper half fades into the lower one, linearly."""
NO_BALANCE = np.ones(3)
"""Colours are counted as they are."""
MEAN_LEVEL = 128.0
"""What the mean of a background becomes in every channel, grey levels."""
COUNTED = 250
"""Pixels of a box that count, at least: those of every second row and column, or third ..."""
_SAMPLED_PX = 16


def balance_of(background: NDArray[np.uint8]) -> NDArray[np.float64]:
    """
    Return by what factors blue, green and red become alike in the mean of a background.

    Cameras are not exposed and balanced alike; what they look at is, in the mean, of one grey
    (grey-world assumption, Buchsbaum 1980).

    Parameters
    ----------
    background : (h, w, 3) uint8 array
        BGR image without what moves.

    """
    step = min(_SAMPLED_PX, *background.shape[:2])
    mean = background[step // 2 :: step, step // 2 :: step].mean(axis=(0, 1))
    return np.asarray(MEAN_LEVEL / np.maximum(mean, 1.0), np.float64)


def colour_templates(
    image: NDArray[np.uint8],
    mask: NDArray[np.uint8],
    box: NDArray[np.integer],
    balance: NDArray[np.float64] = NO_BALANCE,
) -> NDArray[np.float64]:
    """
    Count the colours of the foreground in boxes: of upper halves, and of lower ones.

    A pixel counts for its hue as far as it has colour, and for its brightness by the rest. In a
    large box not every pixel does, see `COUNTED`.

    Parameters
    ----------
    image : (h, w, 3) uint8 array
        BGR image.
    mask : (h, w) uint8 array
        Not zero where a pixel counts.
    box : (n, 4) int array
        Left, top, width, height, px.
    balance : (3,) array
        Factors of blue, green and red; see `balance_of`.

    Returns
    -------
    (n, 48) float64 array
        Each sums to 1. Zero where nothing counts.

    """
    image, mask = np.ascontiguousarray(image), np.ascontiguousarray(mask)
    counted: NDArray[np.float64] = _count(
        image, mask, np.ascontiguousarray(box, np.int64), balance
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
def colour_place(balance: Floats, blue: float, green: float, red: float) -> tuple[float, ...]:
    """
    Return a colour's hue and brightness, in bins, and how far it is a colour.

    Parameters
    ----------
    balance : (3,) array
        Factors of blue, green and red.
    blue, green, red : float
        0 to 255.

    """
    blue, green, red = balance[0] * blue, balance[1] * green, balance[2] * red
    value = max(blue, green, red)
    spread = value - min(blue, green, red)
    level = (0.114 * blue + 0.587 * green + 0.299 * red) * GREYS / 256.0
    if spread == 0.0:
        return 0.0, level, 0.0
    if value == red:
        sixth = (green - blue) / spread
    elif value == green:
        sixth = 2.0 + (blue - red) / spread
    else:
        sixth = 4.0 + (red - green) / spread
    return sixth * (HUES / 6.0), level, spread / value


@inner
def colour_bins(balance: Floats, blue: float, green: float, red: float) -> tuple[int, int, float]:
    """Return the bins of hue and brightness that a colour is in, and the weight of the former."""
    hue, level, weight = colour_place(balance, blue, green, red)
    return int(np.floor(hue)) % HUES, HUES + min(int(level), GREYS - 1), weight


@inner
def colour_shares(
    balance: Floats, blue: float, green: float, red: float
) -> tuple[tuple[int, int, int, int], tuple[float, float, float, float]]:
    """
    Return the bins that a colour lies between, two of hue and two of brightness, and their shares.

    Between the middles of two bins it counts in both, by linear interpolation (Dalal and Triggs
    2005): a small change of colour is a small change of the template.
    """
    hue, level, weight = colour_place(balance, blue, green, red)
    first, level = int(np.floor(hue)), min(max(level - 0.5, 0.0), GREYS - 1.0)
    darker = min(int(level), GREYS - 2)
    later, lighter, rest = hue - first, level - darker, 1.0 - weight
    bins = first % HUES, (first + 1) % HUES, HUES + darker, HUES + darker + 1
    shares = (
        (1.0 - later) * weight, later * weight, (1.0 - lighter) * rest, lighter * rest
    )  # fmt: skip
    return bins, shares


@inner
def upper_share(place: float) -> float:
    """Return the share of the upper half at a place from the head, 0, to the foot, 1."""
    return min(max(0.5 + (0.5 - place) / WAIST, 0.0), 1.0)


@inner
def add_colour(template: Floats, upper: float, balance: Floats, pixel: Bytes) -> None:
    """Count a pixel (3,) in a template (48,): by the share `upper` in its first half."""
    bins, shares = colour_shares(balance, float(pixel[0]), float(pixel[1]), float(pixel[2]))
    for bin, share in zip(bins, shares):
        template[bin] += upper * share
        template[HALF + bin] += (1.0 - upper) * share


@compiled(types.f8[:, ::1](BYTES_3D, BYTES_2D, INTS_2D, FLOATS_1D))
def _count(
    image: NDArray[np.uint8], mask: NDArray[np.uint8], box: NDArray[np.int64], balance: Floats
) -> Floats:
    """Add up pixels box by box."""
    templates = np.zeros((len(box), TEMPLATE_SIZE))
    for index in range(len(box)):
        left, top, width, height = box[index]
        template, count = templates[index], 0
        step = max(int(np.sqrt(max(width * height, 0) / COUNTED)), 1)
        for row in range(max(top, 0), min(top + height, mask.shape[0]), step):
            upper = upper_share((row - top + 0.5) / height)
            for column in range(max(left, 0), min(left + width, mask.shape[1]), step):
                if not mask[row, column]:
                    continue
                count += 1
                add_colour(template, upper, balance, image[row, column])
        template /= max(count, 1)
    return templates
