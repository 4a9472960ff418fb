"""
Which people on the ground explain the masks of all cameras: greedy with moves.

The energy of a set of people is that of Fleuret et al. 2008, "Multicamera people tracking with a
probabilistic occupancy map", without its blur: where the union of the people's boxes and the mask
of a camera differ, as a share of that union, and a cost for each person. A box that others cover
already adds nothing, so whoever stands behind somebody is neither credited nor blamed there.
Vehicles are found likewise, as the outlines of cuboids.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_1D, compiled, inlined, inner

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Boxes = NDArray[np.int16]
Mask = NDArray[np.bool_]
_Columns = tuple[Indices, Floats, Floats, Floats, Floats]

SMALLEST_UNION = 200.0
"""Added to the area of a camera's union, px of the reduced mask: one distant person is no sure
sign (stored four-camera terrace, frames to 1250: 100 to 400 give the same)."""
ROUNDS = 3
"""How often each person is taken out and put back where he fits best."""
MOST_PEOPLE = 500
FREE = 1 << 32
"""What a pixel that no box covers adds to the sums down its column, beside 1 if foreground."""
SURE_GAIN = 0.02
"""Gain that makes a place e times as likely as another: by it the energy's minimum becomes a mean
and a covariance (the same frames: squared errors are as large as these say)."""


class Places(NamedTuple):
    """
    Where people, or vehicles, can be, and what they cover of the masks there.

    Attributes
    ----------
    position : (n, 2) array
        Of the places, m, y ascending.
    boxes : (cameras, n, 4) int16 array
        Left, top, right and bottom (exclusive), px of the mask; without area: not in the image.
    first : (cameras, n) int32 array
        Row of `outline` that is the leftmost column of the box.
    outline : (m, 2) int16 array
        Top and bottom (exclusive) of what is covered in a column, px of the mask; without rows
        boxes are covered wholly.
    reach : float
        How far one moves in a round, m.
    distance : float
        Two are no nearer, m: else who is wider in a mask than usual has a second beside him.

    """

    position: Floats
    boxes: Boxes
    first: NDArray[np.int32]
    outline: Boxes
    reach: float
    distance: float


class Occupancy(NamedTuple):
    """
    The people, or vehicles, that explain the masks.

    Attributes
    ----------
    cell : (n,) int64 array
        Row of the place where each is, in order of being found.
    gain : (n,) array
        By how much the energy is less with him than without.
    mean, covariance : (n, 2), (n, 2, 2) arrays
        Of where he is, m and m², by how the energy rises about its minimum.
    support : (n, cameras) array
        Share of his own box, that which no other covers, that is foreground; NaN: none is left.

    """

    cell: Indices
    gain: Floats
    mean: Floats
    covariance: Floats
    support: Floats


def solve(
    masks: tuple[Bytes, ...], places: Places, prior: Floats, used: Mask, cost: float
) -> Occupancy:
    """
    Return the people, or vehicles, that explain masks.

    Parameters
    ----------
    masks : tuple of (h, w) uint8 arrays
        Of each camera; not 0: foreground.
    places : Places
        Where they can be.
    prior : (n,) array
        What is added to the gain of one there.
    used : (cameras,) bool array
        Which masks count.
    cost : float
        What one costs.

    """
    sizes = np.array([mask.shape for mask in masks], np.int64).reshape(-1, 2)
    height, width = sizes.max(axis=0, initial=1)
    stacked = np.zeros((len(masks), height, width), np.uint8)
    for camera, mask in enumerate(masks):
        stacked[camera, : mask.shape[0], : mask.shape[1]] = mask > 0
    search = _solve_outlines if len(places.outline) else _solve_boxes
    return Occupancy(*search(stacked, places, prior, used, cost))


@inner
def _refresh(
    mask: Bytes, cover: NDArray[np.int16], sums: Indices, left: int, right: int, top: int
) -> None:
    """Write the sums down some columns of what no box covers and of its foreground, from a row."""
    for y in range(top, len(mask)):
        for x in range(left, right):
            is_free = cover[y, x] == 0
            sums[y + 1, x] = sums[y, x] + is_free * (FREE + mask[y, x])


class _Search(NamedTuple):
    """
    What the search works on.

    `cover` counts the boxes over each pixel; `sums` holds, down each column, how many pixels none
    covers, times `FREE`, and how many of these are foreground: a person is narrow and changes few
    columns; `outlined` is None where boxes are covered wholly: its type decides when compiled,
    since a branch in the innermost loops makes the search five times slower; `wrong` and `union`
    are |B xor A| and |A| of the energy, by camera; `taken` counts the people beside whom nobody
    can stand in a cell.
    """

    masks: Bytes
    position: Floats
    boxes: Boxes
    first: NDArray[np.int32]
    outline: Boxes
    outlined: int | None
    reach: float
    distance: float
    prior: Floats
    cost: float
    cover: NDArray[np.int16]
    sums: NDArray[np.int64]
    wrong: Floats
    union: Floats
    taken: Indices


@inner
def _begun(
    masks: Bytes, places: Places, prior: Floats, used: Mask, cost: float, outlined: int | None
) -> _Search:
    """Return a search that has found nobody."""
    cameras, height, width = masks.shape
    position, boxes, first, outline, reach, distance = places
    boxes = boxes.copy()
    for camera in range(cameras):
        if not used[camera]:
            boxes[camera, :, 2] = boxes[camera, :, 0]
    cover = np.zeros((cameras, height, width), np.int16)
    sums = np.zeros((cameras, height + 1, width), np.int64)
    wrong, union = np.zeros(cameras), np.zeros(cameras)
    for camera in range(cameras):
        _refresh(masks[camera], cover[camera], sums[camera], 0, width, 0)
        wrong[camera] = masks[camera].sum()
    taken = np.zeros(len(prior), np.int64)
    return _Search(
        masks, position, boxes, first, outline, outlined, reach, distance, prior, cost, cover,
        sums, wrong, union, taken,
    )  # fmt: skip


@inlined
def _own(search: _Search, camera: int, cell: int) -> tuple[int, int]:
    """Return the pixels of one in a cell that nobody covers, and the foreground among them."""
    sums, boxes, outline = search.sums, search.boxes, search.outline
    left, top = boxes[camera, cell, 0], boxes[camera, cell, 1]
    right, bottom = boxes[camera, cell, 2], boxes[camera, cell, 3]
    total = 0
    if search.outlined is None:
        for x in range(left, right):
            total += sums[camera, bottom, x] - sums[camera, top, x]
    else:
        row = search.first[camera, cell]
        for x in range(left, right):
            column = row + x - left
            total += sums[camera, outline[column, 1], x] - sums[camera, outline[column, 0], x]
    return total // FREE, total % FREE


@inner
def _hopeful(search: _Search) -> Indices:
    """Return the cells where more than half of a person is foreground in some camera."""
    hopeful, count = np.empty(len(search.prior), np.int64), 0
    for cell in range(len(hopeful)):
        for camera in range(len(search.boxes)):
            box = search.boxes[camera, cell]
            if box[2] > box[0]:
                own, lit = _own(search, camera, cell)
                if 2 * lit > own:
                    hopeful[count], count = cell, count + 1
                    break
    return hopeful[:count]


@inner
def _rows(position: Floats, cell: int, reach: float) -> tuple[int, int]:
    """Return the first cell, and the one after the last, that y alone puts within a reach, m."""
    y = position[:, 1]
    first = np.searchsorted(y, y[cell] - reach, side='left')
    return int(first), int(np.searchsorted(y, y[cell] + reach, side='right'))


@inlined
def _gain(search: _Search, cell: int) -> float:
    """Return by how much a person in a cell lowers the energy, but for his cost."""
    boxes, wrong, union = search.boxes, search.wrong, search.union
    gain = 0.0
    for camera in range(len(boxes)):
        if boxes[camera, cell, 2] <= boxes[camera, cell, 0]:
            continue
        own, lit = _own(search, camera, cell)
        gain += wrong[camera] / (union[camera] + SMALLEST_UNION)
        gain -= (wrong[camera] + own - 2 * lit) / (union[camera] + own + SMALLEST_UNION)
    return float(gain + search.prior[cell])


@inner
def _put(search: _Search, by: int, cell: int) -> None:
    """Put a person into a cell (1), or take him out (-1)."""
    for camera in range(len(search.boxes)):
        box = search.boxes[camera, cell]
        if box[2] <= box[0]:
            continue
        left, top, right, bottom = box[0], box[1], box[2], box[3]
        cover, sums = search.cover[camera], search.sums[camera]
        before = _own(search, camera, cell)
        if search.outlined is None:
            for y in range(top, bottom):
                for x in range(left, right):
                    cover[y, x] += by
        else:
            for x in range(left, right):
                column = search.first[camera, cell] + x - left
                for y in range(search.outline[column, 0], search.outline[column, 1]):
                    cover[y, x] += by
        _refresh(search.masks[camera], cover, sums, left, right, top)
        own, lit = before if by > 0 else _own(search, camera, cell)
        search.wrong[camera] += by * (own - 2 * lit)
        search.union[camera] += by * own
    position, least = search.position, search.distance
    for other in range(*_rows(position, cell, least)):
        dx, dy = position[other, 0] - position[cell, 0], position[other, 1] - position[cell, 1]
        if dx * dx + dy * dy < least * least:
            search.taken[other] += by


@inner
def _best(search: _Search, cells: Indices, around: int) -> tuple[int, float]:
    """Return the cell where a person gains most, -1: none; within reach of one, -1: of any."""
    best, highest, position = -1, 0.0, search.position
    first, end, reach = 0, len(cells), search.reach
    if around >= 0:
        lowest, beyond = _rows(position, around, reach)
        first, end = int(np.searchsorted(cells, lowest)), int(np.searchsorted(cells, beyond))
    for place in cells[first:end]:
        if search.taken[place] > 0:
            continue
        if around >= 0:
            dx = position[place, 0] - position[around, 0]
            dy = position[place, 1] - position[around, 1]
            if dx * dx + dy * dy > reach * reach:
                continue
        gain = _gain(search, place) - search.cost
        if gain > highest:
            best, highest = place, gain
    return best, highest


@inner
def _add(search: _Search, cells: Indices, people: Indices, gains: Floats, number: int) -> int:
    """Add people while one lowers the energy; return how many there are."""
    while number < MOST_PEOPLE:
        best, highest = _best(search, cells, -1)
        if best < 0:
            break
        _put(search, 1, best)
        people[number], gains[number], number = best, highest, number + 1
    return number


@inner
def _move(
    search: _Search, cells: Indices, people: Indices, gains: Floats, number: int
) -> tuple[int, bool]:
    """Move each person to where he fits best near by; return how many stay, and if any moved."""
    has_moved, kept = False, 0
    for index in range(number):
        before = people[index]
        _put(search, -1, before)
        best, highest = _best(search, cells, before)
        has_moved |= best != before
        if best >= 0:
            _put(search, 1, best)
            people[kept], gains[kept], kept = best, highest, kept + 1
    return kept, has_moved


@inner
def _measure(search: _Search, cell: int, mean: Floats, covariance: Floats) -> None:
    """Write mean (2,) and covariance (2, 2) of where a person is who was taken out of a cell."""
    position, best = search.position, _gain(search, cell)
    x, y = position[cell, 0], position[cell, 1]
    total = mx = my = xx = xy = yy = 0.0
    reach = 2 * search.reach
    for other in range(*_rows(position, cell, reach)):
        dx, dy = position[other, 0] - x, position[other, 1] - y
        if dx * dx + dy * dy <= reach * reach:
            weight = np.exp((_gain(search, other) - best) / SURE_GAIN)
            total += weight
            mx += weight * dx
            my += weight * dy
            xx += weight * dx * dx
            xy += weight * dx * dy
            yy += weight * dy * dy
    mx, my = mx / total, my / total
    mean[0], mean[1] = x + mx, y + my
    covariance[0, 0], covariance[1, 1] = xx / total - mx * mx, yy / total - my * my
    covariance[0, 1] = covariance[1, 0] = xy / total - mx * my


@inner
def _support(search: _Search, cell: int, support: Floats) -> None:
    """Write which share of a person's box, that no other covers, is foreground, by camera."""
    for camera in range(len(search.boxes)):
        box = search.boxes[camera, cell]
        if box[2] > box[0]:
            own, lit = _own(search, camera, cell)
            if own > 0:
                support[camera] = lit / own


_PLACES = types.NamedTuple(
    [
        types.f8[:, ::1], types.i2[:, :, ::1], types.i4[:, ::1], types.i2[:, ::1], types.f8,
        types.f8,
    ],
    Places,
)  # fmt: skip


@inner
def _explained(search: _Search) -> _Columns:
    """Return the columns of `Occupancy`."""
    cells = _hopeful(search)
    people, gains, number = np.empty(MOST_PEOPLE, np.int64), np.zeros(MOST_PEOPLE), 0
    for _ in range(ROUNDS):
        before = number
        number = _add(search, cells, people, gains, number)
        has_grown = number > before
        number, has_moved = _move(search, cells, people, gains, number)
        if not (has_grown or has_moved):
            break
    else:
        number = _add(search, cells, people, gains, number)
    mean, covariance = np.zeros((number, 2)), np.zeros((number, 2, 2))
    support = np.full((number, len(search.masks)), np.nan)
    for index in range(number):
        cell = people[index]
        _put(search, -1, cell)
        _measure(search, cell, mean[index], covariance[index])
        _support(search, cell, support[index])
        _put(search, 1, cell)
    return people[:number].copy(), gains[:number].copy(), mean, covariance, support


_SOLVED = types.Tuple(
    [types.i8[::1], types.f8[::1], types.f8[:, ::1], types.f8[:, :, ::1], types.f8[:, ::1]]
)(types.u1[:, :, ::1], _PLACES, FLOATS_1D, BOOLS_1D, types.f8)


@compiled(_SOLVED)
def _solve_boxes(masks: Bytes, places: Places, prior: Floats, used: Mask, cost: float) -> _Columns:
    return _explained(_begun(masks, places, prior, used, cost, None))


@compiled(_SOLVED)
def _solve_outlines(
    masks: Bytes, places: Places, prior: Floats, used: Mask, cost: float
) -> _Columns:
    return _explained(_begun(masks, places, prior, used, cost, 1))
