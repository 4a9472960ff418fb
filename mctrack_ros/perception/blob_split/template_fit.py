"""The search behind `partition`, compiled: bodies are tried at every place in their blobs."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    BYTES_2D,
    BYTES_3D,
    FLOATS_1D,
    FLOATS_2D,
    FLOATS_3D,
    compiled,
    inner,
)
from mctrack_ros.perception.blob_split.cell_grid import (
    CellGrid,
    add_cover,
    best_place,
    boxes_of,
    cell_grid_of,
    explained,
    lowest_first,
    templates_of,
    values_of,
    write_tops,
)
from mctrack_ros.perception.blob_split.types import BODIES, MEMBERS, Bodies, Members
from mctrack_ros.perception.geometry.person_size import TALLEST
from mctrack_ros.tracking.kalman import inverted

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]


BODY_WIDTH_M, BODY_SHARE = 0.4, 0.6
"""Least width of a body, m, and its width as a share of the known width of a person in motion,
whose arms and legs reach beyond it; by single views of the terrace, PETS, a street and a match."""
CELLS = 24
"""Cells to the usual height: fewer place feet less well, more cost more."""
BACKGROUND_WEIGHT = 0.9  # cost of background under a body, foreground being worth 1
CERTAINTY = 12.0  # log-likelihood of a wholly explained body
NEW_SHARE, MOST_NEW = 0.6, 4
"""Share of a body newly explained that makes another person, and most of them in a blob. These and
the two above by trial on simulated matches."""
SWEEPS = 2  # rounds of placing each given the others, by trial


@inner
def _is_crowded(cover: Ints) -> bool:
    """Tell whether bodies cover one another."""
    for y in range(cover.shape[0]):
        for x in range(cover.shape[1]):
            if cover[y, x] > 1:
                return True
    return False


@inner
def _place_known(
    canvas: CellGrid, values: Floats, cover: Ints, tops: Ints, bottom: Floats, precision: Floats,
    row: Ints, column: Ints,
) -> None:  # fmt: skip
    """Place each near its prediction given the others, a few times; write row and column."""
    for sweep in range(SWEEPS):
        for index in lowest_first(bottom[:, 1]):
            if sweep:
                add_cover(cover, canvas, tops[index], row[index], column[index], -1)
            row[index], column[index], _ = best_place(
                canvas, values[index], cover, tops[index], CERTAINTY,
                bottom[index], precision[index],
            )  # fmt: skip
            add_cover(cover, canvas, tops[index], row[index], column[index], 1)
        if not _is_crowded(cover):
            break


@inner
def _place_new(
    canvas: CellGrid, value: Floats, cover: Ints, tops: Ints, count: int, row: Ints, column: Ints,
) -> int:  # fmt: skip
    """Add persons while they explain enough; write row and column, return how many there are."""
    while count < len(row):
        row[count], column[count], worth = best_place(
            canvas, value, cover, tops[count], 1.0, np.zeros(2), np.zeros((2, 2))
        )
        if worth < NEW_SHARE:
            break
        add_cover(cover, canvas, tops[count], row[count], column[count], 1)
        count += 1
    return count


@inner
def _place_in(
    image: Bytes, mask: Bytes, box: Floats, scale: float, sizes: Floats, width_m: float,
    bottom: Floats, precision: Floats, height_m: Floats, template: Floats, usual_m: float,
    balance: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:  # fmt: skip
    """Place the persons of one blob: boxes, visible and own_share shares, colours."""
    canvas = cell_grid_of(image, mask, box, scale, sizes, usual_m, width_m, CELLS)
    known, most = len(bottom), len(bottom) + MOST_NEW
    height = np.full(most, usual_m)
    for index in range(known):
        height[index] = height_m[index]
    tops = np.empty((most, len(canvas.metre)), np.int64)
    for index in range(most):
        write_tops(canvas, height[index], tops[index])
    values = values_of(canvas, template, balance, BACKGROUND_WEIGHT)
    cover = np.zeros(canvas.foreground.shape, np.int64)
    row, column = np.zeros(most, np.int64), np.zeros(most, np.int64)
    _place_known(canvas, values, cover, tops, bottom, precision, row, column)
    count = _place_new(canvas, values[known], cover, tops, known, row, column)
    oldest_first = np.arange(count)
    front_first = lowest_first(row[:count])
    own_share = explained(canvas, tops, row, column, oldest_first)
    visible = explained(canvas, tops, row, column, front_first)
    colours = templates_of(image, mask, canvas, balance, tops, row, column, front_first)
    return boxes_of(canvas, row[:count], column[:count], height), visible, own_share, colours


@inner
def _sized(members: Members, blobs: int, usual_m: float) -> tuple[Ints, Floats, Floats]:
    """Return how many are known in each blob, the width of bodies there, and their heights, m."""
    count, width_m = np.zeros(blobs, np.int64), np.full(blobs, BODY_WIDTH_M)
    height_m = np.empty(len(members.blob))
    least_m, most_m = (2 - TALLEST) * usual_m, TALLEST * usual_m
    for row, blob in enumerate(members.blob):
        count[blob] += 1
        width_m[blob] = np.maximum(width_m[blob], BODY_SHARE * members.extent[row, 0])
        height_m[row] = np.minimum(np.maximum(members.extent[row, 1], least_m), most_m)
    return count, width_m, height_m


@compiled(BODIES(BYTES_3D, BYTES_2D, FLOATS_2D, types.f8, FLOATS_3D, MEMBERS, types.f8, FLOATS_1D))
def place(
    image: Bytes, mask: Bytes, blob: Floats, scale: float, sizes: Floats, members: Members,
    usual_height_m: float, balance: Floats,
) -> Bodies:  # fmt: skip
    """
    Place the known persons of some blobs near their predictions, then new ones.

    Parameters
    ----------
    image, mask : (h, w, 3) and (h, w) uint8 arrays
        The image and its cleaned foreground, reduced by `scale`.
    blob : (b, 4) array
        The blobs, px.
    scale : float
        Pixels of the image to one of the mask.
    sizes : (r, c, 4) array
        The camera's `SizeTable.table`.
    members : Members
        Who is known to be in them.
    usual_height_m : float
        Height of a person who is not known, m.
    balance : (3,) array
        Factors of blue, green and red.

    Returns
    -------
    Bodies
        The members and new persons.

    """
    count, width_m, height_m = _sized(members, len(blob), usual_height_m)
    precision = np.empty(members.spread.shape)
    for row in range(len(precision)):
        inverted(members.spread[row], precision[row])
    most = len(members.blob) + len(blob) * MOST_NEW
    blob_of, is_known = np.empty(most, np.int64), np.zeros(most, np.bool_)
    box, colours = np.empty((most, 4)), np.empty((most, members.template.shape[1]))
    visible, own_share = np.empty(most), np.empty(most)
    first = done = 0
    for index in range(len(blob)):
        begin, first = first, first + count[index]
        boxes, seen, explains, reported = _place_in(
            image, mask, blob[index], scale, sizes, width_m[index],
            members.bottom[begin:first], precision[begin:first], height_m[begin:first],
            members.template[begin:first], usual_height_m, balance,
        )  # fmt: skip
        end = done + len(boxes)
        for row in range(done, end):
            body = row - done
            blob_of[row], is_known[row] = index, body < count[index]
            visible[row], own_share[row] = seen[body], explains[body]
            for side in range(4):
                box[row, side] = boxes[body, side]
            for bin in range(colours.shape[1]):
                colours[row, bin] = reported[body, bin]
        done = end
    return Bodies(
        blob_of[:done], is_known[:done], box[:done], visible[:done], own_share[:done],
        colours[:done],
    )  # fmt: skip
