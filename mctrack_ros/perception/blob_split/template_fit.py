"""The search behind `partition`, compiled: bodies are tried at every place in their blobs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    BYTES_2D,
    BYTES_3D,
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
    tops_of,
    values_of,
)
from mctrack_ros.perception.blob_split.types import BODIES, MEMBERS, Bodies, Members
from mctrack_ros.perception.geometry.person_size import TALLEST
from mctrack_ros.tracking.appearance import PALETTE, Palette
from mctrack_ros.tracking.kalman import inverted

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]


class Search(NamedTuple):
    """
    How bodies are placed.

    Attributes
    ----------
    height_m : float
        Usual height, m.
    width_m : float
        Least width of a body, m.
    width_share : float
        Width of a body, as a share of the known width of a person in motion.
    cells : int
        Cells to the usual height.
    background_weight : float
        Cost of background under a body, foreground being worth 1.
    certainty : float
        Log-likelihood of a wholly explained body.
    new_share : float
        Share of a body newly explained that makes another person.
    most_new : int
        Most other persons.
    sweeps : int
        Rounds of placing each given the others.

    """

    height_m: float
    width_m: float
    width_share: float
    cells: int
    background_weight: float
    certainty: float
    new_share: float
    most_new: int
    sweeps: int


SEARCH = types.NamedTuple([*[types.f8] * 3, types.i8, *[types.f8] * 3, *[types.i8] * 2], Search)


@inner
def _place_known(
    canvas: CellGrid, values: Floats, cover: Ints, tops: Ints, bottom: Floats, precision: Floats,
    search: Search, row: Ints, column: Ints,
) -> None:  # fmt: skip
    """Place each near its prediction given the others, a few times; write row and column."""
    for sweep in range(search.sweeps):
        for index in lowest_first(bottom[:, 1]):
            if sweep:
                add_cover(cover, canvas, tops[index], row[index], column[index], -1)
            row[index], column[index], _ = best_place(
                canvas, values[index], cover, tops[index], search.certainty,
                bottom[index], precision[index],
            )  # fmt: skip
            add_cover(cover, canvas, tops[index], row[index], column[index], 1)
        if len(bottom) == 0 or cover.max() < 2:
            break


@inner
def _place_new(
    canvas: CellGrid, value: Floats, cover: Ints, tops: Ints, new_share: float,
    count: int, row: Ints, column: Ints,
) -> int:  # fmt: skip
    """Add persons while they explain enough; write row and column, return how many there are."""
    while count < len(row):
        row[count], column[count], worth = best_place(
            canvas, value, cover, tops[count], 1.0, np.zeros(2), np.zeros((2, 2))
        )
        if worth < new_share:
            break
        add_cover(cover, canvas, tops[count], row[count], column[count], 1)
        count += 1
    return count


@inner
def _place_in(
    image: Bytes, mask: Bytes, box: Floats, scale: float, sizes: Floats, width_m: float,
    bottom: Floats, precision: Floats, height_m: Floats, template: Floats, palette: Palette,
    search: Search,
) -> tuple[Floats, Floats, Floats, Floats]:  # fmt: skip
    """Place the persons of one blob: boxes, visible and proven shares, colours."""
    canvas = cell_grid_of(image, mask, box, scale, sizes, search.height_m, width_m, search.cells)
    known, most = len(bottom), len(bottom) + search.most_new
    height = np.full(most, search.height_m)
    height[:known] = height_m
    tops = np.empty((most, len(canvas.metre)), np.int64)
    for index in range(most):
        tops[index] = tops_of(canvas, height[index])
    values = values_of(canvas, template, palette, search.background_weight)
    cover = np.zeros(canvas.foreground.shape, np.int64)
    row, column = np.zeros(most, np.int64), np.zeros(most, np.int64)
    _place_known(canvas, values, cover, tops, bottom, precision, search, row, column)
    count = _place_new(canvas, values[known], cover, tops, search.new_share, known, row, column)
    oldest_first = np.arange(count)
    front_first = lowest_first(row[:count])
    proven = explained(canvas, tops, row, column, oldest_first)
    visible = explained(canvas, tops, row, column, front_first)
    colours = templates_of(image, mask, canvas, palette, tops, row, column, front_first)
    return boxes_of(canvas, row[:count], column[:count], height), visible, proven, colours


@inner
def _sized(members: Members, blobs: int, search: Search) -> tuple[Ints, Floats, Floats]:
    """Return how many are known in each blob, the width of bodies there, and their heights, m."""
    count, width_m = np.zeros(blobs, np.int64), np.full(blobs, search.width_m)
    height_m = np.empty(len(members.blob))
    least_m, most_m = (2 - TALLEST) * search.height_m, TALLEST * search.height_m
    for row, blob in enumerate(members.blob):
        count[blob] += 1
        width_m[blob] = np.maximum(width_m[blob], search.width_share * members.extent[row, 0])
        height_m[row] = np.minimum(np.maximum(members.extent[row, 1], least_m), most_m)
    return count, width_m, height_m


@compiled(BODIES(BYTES_3D, BYTES_2D, FLOATS_2D, types.f8, FLOATS_3D, MEMBERS, PALETTE, SEARCH))
def place(
    image: Bytes, mask: Bytes, blob: Floats, scale: float, sizes: Floats, members: Members,
    palette: Palette, search: Search,
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
    palette : Palette
        What templates count.
    search : Search
        Parameters.

    Returns
    -------
    Bodies
        The members and new persons.

    """
    count, width_m, height_m = _sized(members, len(blob), search)
    precision = np.empty(members.spread.shape)
    for row in range(len(precision)):
        inverted(members.spread[row], precision[row])
    most = len(members.blob) + len(blob) * search.most_new
    blob_of, is_known = np.empty(most, np.int64), np.zeros(most, np.bool_)
    box, colours = np.empty((most, 4)), np.empty((most, members.template.shape[1]))
    visible, proven = np.empty(most), np.empty(most)
    first = done = 0
    for index in range(len(blob)):
        own = slice(first, first + count[index])
        first += count[index]
        boxes, seen, explains, reported = _place_in(
            image, mask, blob[index], scale, sizes, width_m[index], members.bottom[own],
            precision[own], height_m[own], members.template[own], palette, search,
        )  # fmt: skip
        end = done + len(boxes)
        blob_of[done:end], is_known[done : done + count[index]] = index, True
        box[done:end], visible[done:end], proven[done:end] = boxes, seen, explains
        colours[done:end] = reported
        done = end
    return Bodies(
        blob_of[:done], is_known[:done], box[:done].copy(), visible[:done], proven[:done],
        colours[:done].copy(),
    )  # fmt: skip
