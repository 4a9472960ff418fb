"""The search behind `partition`, compiled: bodies are tried at every place in their blobs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    BYTES_2D,
    BYTES_3D,
    FLOATS_1D,
    FLOATS_2D,
    FLOATS_3D,
    INTS_1D,
    compiled,
    inner,
)
from mctrack_ros.perception.canvas import (
    Canvas,
    add_cover,
    best_place,
    boxes_of,
    canvas_of,
    explained,
    lowest_first,
    templates_of,
    tops_of,
    values_of,
)
from mctrack_ros.tracking.appearance import PALETTE, Palette

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
    cells: int
    background_weight: float
    certainty: float
    new_share: float
    most_new: int
    sweeps: int


SEARCH = types.NamedTuple([types.f8, types.i8, *[types.f8] * 3, *[types.i8] * 2], Search)
PLACED = types.Tuple(
    [types.f8[:, ::1], types.f8[::1], types.f8[::1], types.f8[:, ::1], types.i8[::1]]
)


@inner
def _place_known(
    canvas: Canvas, values: Floats, cover: Ints, tops: Ints, bottom: Floats, precision: Floats,
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
    canvas: Canvas, value: Floats, cover: Ints, tops: Ints, new_share: float,
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
    canvas = canvas_of(image, mask, box, scale, sizes, search.height_m, width_m, search.cells)
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


@compiled(
    PLACED(
        BYTES_3D, BYTES_2D, FLOATS_2D, types.f8, FLOATS_3D, FLOATS_1D, INTS_1D,
        FLOATS_2D, FLOATS_3D, FLOATS_1D, FLOATS_2D, PALETTE, SEARCH,
    )
)  # fmt: skip
def place(
    image: Bytes,
    mask: Bytes,
    blob: Floats,
    scale: float,
    sizes: Floats,
    width_m: Floats,
    count: Ints,
    bottom: Floats,
    precision: Floats,
    height_m: Floats,
    template: Floats,
    palette: Palette,
    search: Search,
) -> tuple[Floats, Floats, Floats, Floats, Ints]:
    """
    Place the known persons of some blobs near their predictions, then new ones.

    Parameters
    ----------
    image, mask : (h, w, 3) and (h, w) uint8 arrays
        The picture and its cleaned foreground, reduced by `scale`.
    blob : (b, 4) array
        The blobs, px.
    scale : float
        Pixels of the picture to one of the mask.
    sizes : (r, c, 3) array
        The camera's `SizeTable.table`.
    width_m : (b,) array
        Width of all bodies in each blob, m.
    count : (b,) int64 array
        Known persons of each; they follow one another, n in all.
    bottom : (n, 2) array
        Predicted bottom centres, px.
    precision : (n, 2, 2) array
        Inverse of their covariance, 1/px².
    height_m : (n,) array
        Heights, m.
    template : (n, 48) array
        Colours, zero where not known.
    palette : Palette
        What templates count.
    search : Search
        Parameters.

    Returns
    -------
    box : (m, 4) array
        Blob by blob the known, then new ones; left, top, width, height, px.
    visible : (m,) array
        Share of each that is foreground past those nearer to the camera.
    proven : (m,) array
        Share of each that is foreground past those before it.
    template : (m, 48) array
        Colours of what is seen of each; zero where nothing is.
    found : (b,) int64 array
        Persons placed in each blob.

    """
    most = len(bottom) + len(blob) * search.most_new
    box, colours = np.empty((most, 4)), np.empty((most, template.shape[1]))
    visible, proven = np.empty(most), np.empty(most)
    found = np.empty(len(blob), np.int64)
    first = done = 0
    for index in range(len(blob)):
        own = slice(first, first + count[index])
        first += count[index]
        boxes, seen, explains, told = _place_in(
            image, mask, blob[index], scale, sizes, width_m[index],
            bottom[own], precision[own], height_m[own], template[own], palette, search,
        )  # fmt: skip
        found[index] = len(boxes)
        end = done + len(boxes)
        box[done:end], visible[done:end], proven[done:end] = boxes, seen, explains
        colours[done:end] = told
        done = end
    return box[:done].copy(), visible[:done], proven[:done], colours[:done].copy(), found
