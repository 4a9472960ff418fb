"""
Which people on the ground explain the masks of all cameras: greedy with moves.

The energy of a set of people is that of Fleuret et al. 2008, "Multicamera people tracking with a
probabilistic occupancy map", without its blur: where the union of the people's boxes and the mask
of a camera differ, as a share of that union, and a cost for each person. A box that others cover
already adds nothing, so whoever stands behind somebody is neither credited nor blamed there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_1D, FLOATS_2D, compiled, inner

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Counts = NDArray[np.int32]
Boxes = NDArray[np.int16]

SMALLEST_UNION = 200.0
"""Added to the area of a camera's union, px of the reduced mask: one distant person is no sure
sign (stored four-camera terrace, frames to 1250: 100 to 400 give the same)."""
ROUNDS = 3
"""How often each person is taken out and put back where he fits best."""
REACH_M = 0.45
"""How far a person moves in a round, m: three cells."""
LEAST_DISTANCE_M = 0.4
"""Two people are no nearer, m: else who is wider in a mask than a person has a second beside him.
0.3 to 0.5 give the same on the four-camera terrace to frame 1250; without, 2 switches more."""
MOST_PEOPLE = 500
SURE_GAIN = 0.02
"""Gain that makes a place e times as likely as another: by it the energy's minimum becomes a mean
and a covariance (the same frames: squared errors are as large as these say)."""


class Occupancy(NamedTuple):
    """
    The people that explain the masks.

    Attributes
    ----------
    cell : (n,) int64 array
        Where each is, in order of being found.
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
    masks: tuple[Bytes, ...],
    boxes: Boxes,
    position: Floats,
    prior: Floats,
    used: NDArray[np.bool_],
    cost: float,
) -> Occupancy:
    """
    Return the people that explain masks.

    Parameters
    ----------
    masks : tuple of (h, w) uint8 arrays
        Of each camera; not 0: foreground.
    boxes : (cameras, cells, 4) int16 array
        Left, top, right and bottom (exclusive) of a person in each cell, px of the mask; without
        area: he is not in the image.
    position : (cells, 2) array
        Of the cells, m.
    prior : (cells,) array
        What is added to the gain of a person there.
    used : (cameras,) bool array
        Which masks count.
    cost : float
        What a person costs.

    """
    sizes = np.array([mask.shape for mask in masks], np.int64).reshape(-1, 2)
    height, width = sizes.max(axis=0, initial=1)
    stacked = np.zeros((len(masks), height, width), np.uint8)
    for camera, mask in enumerate(masks):
        stacked[camera, : mask.shape[0], : mask.shape[1]] = mask > 0
    return Occupancy(*_solve(stacked, boxes, position, prior, used, cost))


@inner
def _refresh(
    mask: Bytes, cover: NDArray[np.int16], free: Counts, found: Counts, left: int, top: int
) -> None:
    """Write the integral images of what no box covers and of its foreground, from a corner."""
    height, width = mask.shape
    for y in range(top, height):
        own = free[y + 1, left] - free[y, left]
        lit = found[y + 1, left] - found[y, left]
        for x in range(left, width):
            if cover[y, x] == 0:
                own += 1
                lit += mask[y, x]
            free[y + 1, x + 1] = free[y, x + 1] + own
            found[y + 1, x + 1] = found[y, x + 1] + lit


@inner
def _inside(integral: Counts, box: Boxes) -> int:
    """Return the sum of a box of which the integral image is known."""
    left, top, right, bottom = box[0], box[1], box[2], box[3]
    total: int = (
        integral[bottom, right]
        - integral[top, right]
        - integral[bottom, left]
        + integral[top, left]
    )
    return total


@inner
def _gain(
    cell: int, boxes: Boxes, free: Counts, found: Counts, wrong: Floats, union: Floats
) -> float:
    """Return by how much a person in a cell lowers the energy."""
    gain = 0.0
    for camera in range(len(boxes)):
        box = boxes[camera, cell]
        if box[2] <= box[0]:
            continue
        own = _inside(free[camera], box)
        lit = _inside(found[camera], box)
        gain += wrong[camera] / (union[camera] + SMALLEST_UNION)
        gain -= (wrong[camera] + own - 2 * lit) / (union[camera] + own + SMALLEST_UNION)
    return gain


@inner
def _put(
    by: int,
    cell: int,
    boxes: Boxes,
    masks: Bytes,
    cover: NDArray[np.int16],
    free: Counts,
    found: Counts,
    wrong: Floats,
    union: Floats,
) -> None:
    """Put a person into a cell (1), or take him out (-1)."""
    for camera in range(len(boxes)):
        box = boxes[camera, cell]
        if box[2] <= box[0]:
            continue
        left, top = box[0], box[1]
        if by > 0:
            own, lit = _inside(free[camera], box), _inside(found[camera], box)
        for y in range(top, box[3]):
            for x in range(left, box[2]):
                cover[camera, y, x] += by
        _refresh(masks[camera], cover[camera], free[camera], found[camera], left, top)
        if by < 0:
            own, lit = _inside(free[camera], box), _inside(found[camera], box)
        wrong[camera] += by * (own - 2 * lit)
        union[camera] += by * own


@inner
def _take(by: int, cell: int, position: Floats, taken: Indices) -> None:
    """Count (1) or leave (-1) the cells in which nobody else can stand beside a person."""
    for other in range(len(taken)):
        dx = position[other, 0] - position[cell, 0]
        dy = position[other, 1] - position[cell, 1]
        if dx * dx + dy * dy < LEAST_DISTANCE_M * LEAST_DISTANCE_M:
            taken[other] += by


@compiled(
    types.Tuple(
        [types.i8[::1], types.f8[::1], types.f8[:, ::1], types.f8[:, :, ::1], types.f8[:, ::1]]
    )(
        types.u1[:, :, ::1], types.i2[:, :, ::1], FLOATS_2D, FLOATS_1D, BOOLS_1D, types.f8
    )
)  # fmt: skip
def _solve(
    masks: Bytes,
    every_box: Boxes,
    position: Floats,
    prior: Floats,
    used: NDArray[np.bool_],
    cost: float,
) -> tuple[Indices, Floats, Floats, Floats, Floats]:
    cameras, height, width = masks.shape
    boxes = every_box.copy()
    for camera in range(cameras):
        if not used[camera]:
            boxes[camera, :, 2] = boxes[camera, :, 0]
    cover = np.zeros((cameras, height, width), np.int16)
    free = np.zeros((cameras, height + 1, width + 1), np.int32)
    found = np.zeros((cameras, height + 1, width + 1), np.int32)
    wrong, union = np.zeros(cameras), np.zeros(cameras)
    for camera in range(cameras):
        _refresh(masks[camera], cover[camera], free[camera], found[camera], 0, 0)
        wrong[camera] = found[camera, height, width]
    # nobody is looked for where no camera has foreground in more than half of his box
    hopeful = np.empty(len(prior), np.int64)
    count = 0
    for cell in range(len(prior)):
        for camera in range(cameras):
            box = boxes[camera, cell]
            if box[2] > box[0]:
                own, lit = _inside(free[camera], box), _inside(found[camera], box)
                if 2 * lit > own:
                    hopeful[count] = cell
                    count += 1
                    break
    hopeful = hopeful[:count]
    people = np.empty(MOST_PEOPLE, np.int64)
    taken = np.zeros(len(prior), np.int64)
    gains = np.zeros(MOST_PEOPLE)
    number = 0
    for turn in range(ROUNDS + 1):
        before = number
        while number < MOST_PEOPLE:
            best, highest = -1, 0.0
            for place in hopeful:
                if taken[place] > 0:
                    continue
                gain = _gain(int(place), boxes, free, found, wrong, union) + prior[place] - cost
                if gain > highest:
                    best, highest = int(place), gain
            if best < 0:
                break
            _put(1, best, boxes, masks, cover, free, found, wrong, union)
            _take(1, best, position, taken)
            people[number], gains[number] = best, highest
            number += 1
        if turn == ROUNDS:
            break
        has_changed = number > before
        index = 0
        while index < number:
            own_cell = people[index]
            _put(-1, own_cell, boxes, masks, cover, free, found, wrong, union)
            _take(-1, own_cell, position, taken)
            best, highest = -1, 0.0
            x, y = position[own_cell, 0], position[own_cell, 1]
            for place in hopeful:
                dx, dy = position[place, 0] - x, position[place, 1] - y
                if taken[place] == 0 and dx * dx + dy * dy <= REACH_M * REACH_M:
                    gain = (
                        _gain(int(place), boxes, free, found, wrong, union) + prior[place] - cost
                    )
                    if gain > highest:
                        best, highest = int(place), gain
            if best < 0:
                for later in range(index, number - 1):
                    people[later], gains[later] = people[later + 1], gains[later + 1]
                number -= 1
                has_changed = True
                continue
            _put(1, best, boxes, masks, cover, free, found, wrong, union)
            _take(1, best, position, taken)
            has_changed |= best != own_cell
            people[index], gains[index] = best, highest
            index += 1
        if not has_changed:
            break
    mean, covariance = np.zeros((number, 2)), np.zeros((number, 2, 2))
    support = np.full((number, cameras), np.nan)
    for index in range(number):
        own_cell = people[index]
        _put(-1, own_cell, boxes, masks, cover, free, found, wrong, union)
        best_gain = _gain(own_cell, boxes, free, found, wrong, union) + prior[own_cell]
        x, y = position[own_cell, 0], position[own_cell, 1]
        total = mx = my = xx = xy = yy = 0.0
        for cell in range(len(prior)):
            dx, dy = position[cell, 0] - x, position[cell, 1] - y
            if dx * dx + dy * dy <= 4 * REACH_M * REACH_M:
                gain = _gain(cell, boxes, free, found, wrong, union) + prior[cell]
                weight = np.exp((gain - best_gain) / SURE_GAIN)
                total += weight
                mx += weight * dx
                my += weight * dy
                xx += weight * dx * dx
                xy += weight * dx * dy
                yy += weight * dy * dy
        mx, my = mx / total, my / total
        mean[index, 0], mean[index, 1] = x + mx, y + my
        covariance[index, 0, 0], covariance[index, 1, 1] = (
            xx / total - mx * mx,
            yy / total - my * my,
        )
        covariance[index, 0, 1] = covariance[index, 1, 0] = xy / total - mx * my
        for camera in range(cameras):
            box = boxes[camera, own_cell]
            if box[2] > box[0]:
                own, lit = _inside(free[camera], box), _inside(found[camera], box)
                if own > 0:
                    support[index, camera] = lit / own
        _put(1, own_cell, boxes, masks, cover, free, found, wrong, union)
    return people[:number].copy(), gains[:number].copy(), mean, covariance, support
