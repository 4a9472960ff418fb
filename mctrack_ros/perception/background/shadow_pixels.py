"""Which foreground pixels may be shadow, and whose they would be; compiled."""

from __future__ import annotations

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, BYTES_3D, FLOATS_1D, FLOATS_2D, compiled, inner

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
WRITABLE = types.Array(types.u1, 2, 'C')
FLOATS_4D = types.Array(types.f8, 4, 'C', readonly=True)

FIELD_PX = 16
"""Every so many pixels, in both directions, it is known how the ground lies."""

GROUND, BODY, SHADE, SHADOW = 0, 1, 2, 3
STEP_PX = 1.5
HALF_BODY_M = 0.25  # shade of a shoulder falls so far beside the line through the feet
LEAST_GAP_PX = 3.0
SURE_HITS = 2  # one pixel at a shadow's rim may look like a body's
UPRIGHT = 0.4  # tangent of the angle from the upright within which bodies hide shadows
BRIGHTEST = 1.15  # what is hardly another colour or darker is ground at a shadow's rim
ALIKE, SIGMAS = 0.12, 3.0  # how well a channel must fit: a share, and of the noise
VOTER_PX = 3  # of so many rows and columns one votes
NO_SHADE = 0.02  # share of other pixels that what is nothing but shade has at most
LEAST_SHADE = 0.9  # and of shade, at least; the rest is hardly darker than the ground
DARKEST, SPREAD = 0.5, 0.12  # its factor's median, and the quartiles' distance at most
LEAST_PX = 60  # fewer pixels do not tell
BINS = 120  # of 0.01 of the factor


@inner
def _kind_of(
    new: Image,
    old: Image,
    tint: Floats,
    part: Floats,
    darkest: float,
    brightest: float,
    slack: float,
) -> int:
    before = max(float(old[0]) + float(old[1]) + float(old[2]), 1.0)
    factor = (new[0] * part[0] + new[1] * part[1] + new[2] * part[2]) / before
    if not darkest <= factor <= BRIGHTEST:
        return BODY
    for channel in range(3):
        expected = factor * tint[channel] * old[channel]
        if abs(new[channel] - expected) > ALIKE * old[channel] + slack:
            return BODY
    return SHADE if factor <= brightest else GROUND


@inner
def _is_left(field: Floats, y: int, x: int, direction: Floats) -> bool:
    across = field[y // FIELD_PX, x // FIELD_PX, 0]
    return bool(across[0] * direction[0] + across[1] * direction[1] < 0.0)


@inner
def _walk(
    kind: Image, field: Floats, y: int, x: int, east: float, north: float, longest_m: float
) -> int:
    """
    Go over the ground from a pixel and return what comes first: a body, or open ground.

    What is known to be shadow counts as the body that throws it, and so does the image's edge:
    somebody may be beyond it. Where the way goes along the upright, or there is no ground, it is
    `SHADE`: nothing can be told.
    """
    height, width = kind.shape
    row, column = y // FIELD_PX, x // FIELD_PX
    right = field[row, column, 0, 0] * east + field[row, column, 0, 1] * north
    down = field[row, column, 1, 0] * east + field[row, column, 1, 1] * north
    length = math.hypot(right, down)
    if not length > 0.0 or abs(right) < UPRIGHT * abs(down):
        return SHADE
    reach = HALF_BODY_M * math.hypot(field[row, column, 1, 0], field[row, column, 1, 1])
    most, gaps = max(HALF_BODY_M * length, LEAST_GAP_PX) / STEP_PX, 0
    hits = 0
    for step in range(1, int(longest_m * length / STEP_PX) + 1):
        column = int(x + 0.5 + right / length * STEP_PX * step)
        row = int(y + 0.5 + down / length * STEP_PX * step)
        if not (0 <= row < height and 0 <= column < width):
            return BODY
        if kind[row, column] == SHADOW:
            return BODY
        if kind[row, column] == BODY or kind[max(int(row - reach), 0), column] == BODY:
            hits += 1
            if hits == SURE_HITS:
                return BODY
        elif kind[row, column] == GROUND:
            gaps += 1
            if gaps > most:
                return GROUND
    return GROUND


@compiled(
    types.i8(BYTES_3D, BYTES_3D, BYTES_2D, FLOATS_1D, types.f8, types.f8, types.f8, WRITABLE)
)
def mark(
    image: Image,
    model: Image,
    mask: Image,
    tint: Floats,
    darkest: float,
    brightest: float,
    noise: float,
    kind: Image,
) -> int:
    """
    Tell what each pixel may be: ground, a body or the shade of one.

    In shade all channels are darker by one factor, whatever the ground's texture.

    Parameters
    ----------
    image, model : (h, w, 3) uint8 array
        Image and background.
    mask : (h, w) uint8 array
        Foreground.
    tint : (3,) array
        What the factors of blue, green and red are as shares of their mean.
    darkest, brightest : float
        Range of the factor.
    noise : float
        Standard deviation of a channel, grey levels.
    kind : (h, w) uint8 array
        Is overwritten by `GROUND`, `BODY` and `SHADE`.

    Returns
    -------
    int
        Number of pixels of `BODY`.

    """
    new, old, shown = image.reshape(-1, 3), model.reshape(-1, 3), mask.reshape(-1)
    out, count = kind.reshape(-1), 0
    words = shown[: len(shown) // 8 * 8].view(np.uint64)
    part, slack = 1.0 / tint, SIGMAS * noise
    kind[:] = GROUND
    for word in range(len(words) + 1):
        first, last = 8 * word, 8 * word + 8
        if word == len(words):
            last = len(shown)
        elif words[word] == 0:
            continue
        for index in range(first, last):
            if shown[index]:
                found = _kind_of(new[index], old[index], tint, part, darkest, brightest, slack)
                out[index] = found
                count += found == BODY
    return count


@compiled(types.f8[:, ::1](BYTES_3D, BYTES_3D, WRITABLE, FLOATS_4D, FLOATS_2D, types.f8))
def votes(
    image: Image,
    model: Image,
    kind: Image,
    field: Floats,
    direction: Floats,
    longest_m: float,
) -> Floats:
    """
    Let pixels that may be shade vote for where on the ground the sun stands.

    Shade lies between a body, towards the sun, and open ground on the other side.

    Parameters
    ----------
    image, model : (h, w, 3) uint8 array
        Image and background.
    kind : (h, w) uint8 array
        What `mark` wrote.
    field : (r, c, 2, 2) array
        How the image moves with the ground, px/m, every `FIELD_PX` pixels; NaN: no ground.
    direction : (n, 2) array
        Unit vectors on the ground.
    longest_m : float
        Longest shadow, m.

    Returns
    -------
    (n, 5) array
        For each direction: pixels that voted for it, pixels that were asked, and the sums of the
        factors of blue, green and red of those that voted for it.

    """
    found = np.zeros((len(direction), 5))
    for y in range(0, kind.shape[0], VOTER_PX):
        for x in range(0, kind.shape[1], VOTER_PX):
            if kind[y, x] != SHADE:
                continue
            for index in range(len(direction)):
                east, north = direction[index, 0], direction[index, 1]
                ahead = _walk(kind, field, y, x, east, north, longest_m)
                if ahead == SHADE:
                    continue
                found[index, 1] += 1.0
                if ahead == BODY and (
                    _walk(kind, field, y, x, -east, -north, longest_m) == GROUND
                ):
                    found[index, 0] += 1.0
                    for channel in range(3):
                        before = max(model[y, x, channel], 1)
                        found[index, 2 + channel] += image[y, x, channel] / before
    return found


@compiled(types.void(WRITABLE, FLOATS_4D, FLOATS_1D, types.f8, WRITABLE))
def remove(kind: Image, field: Floats, direction: Floats, longest_m: float, mask: Image) -> None:
    """
    Take out of a mask the shade that hangs, over the ground and towards the sun, on a body.

    Parameters
    ----------
    kind, field, longest_m
        As in `votes`; what is taken out becomes `SHADOW`.
    direction : (2,) array
        To the sun, a unit vector on the ground.
    mask : (h, w) uint8 array
        Foreground; changed in place.

    """
    flat, width = kind.reshape(-1), kind.shape[1]
    words = flat[: len(flat) // 8 * 8].view(np.uint64)
    for leftward in (True, False):  # from the sun on, so that ways to it are short
        for count in range(len(words)):
            word = count if leftward else len(words) - 1 - count
            if words[word] == 0:
                continue
            for offset in range(8):
                index = 8 * word + (offset if leftward else 7 - offset)
                y, x = index // width, index % width
                if flat[index] != SHADE or _is_left(field, y, x, direction) != leftward:
                    continue
                if _walk(kind, field, y, x, direction[0], direction[1], longest_m) == BODY:
                    flat[index] = SHADOW
                    mask[y, x] = 0


@compiled(types.void(BYTES_3D, BYTES_3D, types.f8, WRITABLE))
def remove_faint(image: Image, model: Image, darkest: float, mask: Image) -> None:
    """
    Take out of a foreground what is no brighter in any channel and hardly darker in any.

    Parameters
    ----------
    image, model : (h, w, 3) uint8 array
        Image and background.
    darkest : float
        Share of a channel that is left at least.
    mask : (h, w) uint8 array
        Foreground, 255; changed in place.

    """
    new, old, shown = image.reshape(-1, 3), model.reshape(-1, 3), mask.reshape(-1)
    for index in range(len(shown)):
        if shown[index] == 0:
            continue
        faint = True
        for channel in range(3):
            before, now = old[index, channel], new[index, channel]
            faint &= (now <= before) & (now >= darkest * before)
        if faint:
            shown[index] = 0


@compiled(types.f8(BYTES_3D, types.i8))
def colourfulness(image: Image, step: int) -> float:
    """Return by how much blue and red differ in the mean, grey levels, in every so many pixels."""
    difference, count = 0.0, 0
    for y in range(0, image.shape[0], step):
        for x in range(0, image.shape[1], step):
            difference += abs(float(image[y, x, 0]) - float(image[y, x, 2]))
            count += 1
    return difference / count


@inner
def _quantile(found: Ints, rank: float) -> int:
    """Return the first bin up to which there are so many."""
    total, place = found[0], 0
    while total < rank:
        place += 1
        total += found[place]
    return place


@compiled(
    types.b1[::1](BYTES_3D, BYTES_3D, BYTES_2D, FLOATS_2D, FLOATS_1D, types.f8, types.f8, types.f8)
)
def nothing_but_shade(
    image: Image,
    model: Image,
    mask: Image,
    box: Floats,
    area: Floats,
    darkest: float,
    brightest: float,
    noise: float,
) -> NDArray[np.bool_]:
    """
    Tell which boxes hold nothing but shade, darker by one factor all over.

    Parameters
    ----------
    image, model, mask, darkest, brightest, noise
        As in `mark`.
    box : (n, 4) array
        Left, top, width, height, px.
    area : (n,) array
        Foreground in each, px.

    """
    shade, tint = np.zeros(len(box), np.bool_), np.ones(3)
    slack = SIGMAS * noise
    for one in range(len(box)):
        left, top = round(box[one, 0]), round(box[one, 1])
        right, bottom = left + round(box[one, 2]), top + round(box[one, 3])
        count, dark, others, most = 0, 0, 0, NO_SHADE * area[one]
        found = np.zeros(BINS, np.int64)
        for y in range(max(top, 0), min(bottom, mask.shape[0])):
            for x in range(max(left, 0), min(right, mask.shape[1])):
                if mask[y, x] == 0:
                    continue
                new, old = image[y, x], model[y, x]
                kind = _kind_of(new, old, tint, tint, darkest, brightest, slack)
                if kind == BODY:
                    others += 1
                    continue
                before = max(float(old[0]) + float(old[1]) + float(old[2]), 1.0)
                factor = (float(new[0]) + float(new[1]) + float(new[2])) / before
                found[min(int(factor * 100), BINS - 1)] += 1
                count, dark = count + 1, dark + (kind == SHADE)
            if others > most:
                break
        if others > most or count < LEAST_PX or dark < LEAST_SHADE * (count + others):
            continue
        low, high = _quantile(found, 0.25 * count), _quantile(found, 0.75 * count)
        middle = _quantile(found, 0.5 * count)
        is_even = (high - low) * 0.01 <= SPREAD
        shade[one] = is_even and middle * 0.01 >= DARKEST
    return shade
