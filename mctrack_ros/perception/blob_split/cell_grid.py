"""A blob's foreground in cells, in which bodies are placed; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.compiled import inner
from mctrack_ros.interfaces import TEMPLATE_SIZE
from mctrack_ros.perception.geometry.person_size import TALLEST, metre_at
from mctrack_ros.tracking.appearance import HALF, add_colour, colour_shares, is_empty, upper_share

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

COUNTED_PX = 2  # of so many rows and columns one counts for a template
RARE = 0.01  # likelihood of a colour that was not seen before


class CellGrid(NamedTuple):
    """
    The blob in cells, with a margin of background into which bodies may reach.

    A place is a cell (row, column), counted without the margin, at the middle of a body's lower
    edge.

    Attributes
    ----------
    foreground : (above + rows, columns + width) float64 array
        Share of each cell that is foreground.
    colour : (rows, columns, 3) float64 array
        Mean colour, BGR.
    metre : (rows,) float64 array
        Cells to an upright metre whose foot is in a row; 0 above the horizon.
    above, width : int
        Rows of margin at the top; columns of a body, which are those of margin too.
    left, top, step : float
        Where the first cell is and how large cells are, px.
    part : (4,) int64 array
        Left, top, right, bottom of the blob, pixels of the reduced image.

    """

    foreground: Floats
    colour: Floats
    metre: Floats
    above: int
    width: int
    left: float
    top: float
    step: float
    part: Ints


@inner
def cell_grid_of(
    image: Bytes,
    mask: Bytes,
    box: Floats,
    scale: float,
    sizes: Floats,
    height_m: float,
    width_m: float,
    cells: int,
) -> CellGrid:
    """Reduce a blob to cells of which a person of usual height spans so many."""
    left, top, width, height = box[0], box[1], box[2], box[3]
    middle = left + width / 2
    expected = metre_at(sizes, middle, top + height)[1] * height_m
    step = max(expected / cells, scale)
    first_x, first_y = round(left / scale), round(top / scale)
    last_x, last_y = round((left + width) / scale), round((top + height) / scale)
    columns = max(1, min(math.ceil(width / step), last_x - first_x))
    rows = max(1, min(math.ceil(height / step), last_y - first_y))
    metre, tallest = np.empty(rows), 0.0
    for row in range(rows):
        upright = metre_at(sizes, middle, top + (row + 1) * step)[1]
        metre[row] = upright / step if upright > 0 else 0.0
        tallest = max(tallest, metre[row])
    across = metre_at(sizes, middle, top + height)[0] / step
    body = max(1, round(across * width_m))
    above = math.ceil(tallest * (TALLEST + 0.05) * height_m)
    side = body // 2
    foreground = np.zeros((above + rows, columns + body))
    colour, count = np.zeros((rows, columns, 3)), np.zeros((rows, columns))
    for y in range(first_y, last_y):
        row = (y - first_y) * rows // (last_y - first_y)
        for x in range(first_x, last_x):
            column = (x - first_x) * columns // (last_x - first_x)
            count[row, column] += 1.0
            foreground[above + row, side + column] += mask[y, x] > 0
            for channel in range(3):
                colour[row, column, channel] += image[y, x, channel]
    for row in range(rows):
        for column in range(columns):
            foreground[above + row, side + column] /= count[row, column]
            for channel in range(3):
                colour[row, column, channel] /= count[row, column]
    part = np.empty(4, np.int64)
    part[0], part[1], part[2], part[3] = first_x, first_y, last_x, last_y
    return CellGrid(foreground, colour, metre, above, body, left, top, step, part)


@inner
def write_tops(canvas: CellGrid, height_m: float, tops: Ints) -> None:
    """Write the first row, margin counted, of a body standing in each row."""
    for row in range(len(tops)):
        bottom = canvas.above + row + 1
        tops[row] = bottom - min(max(round(canvas.metre[row] * height_m), 1), bottom)


@inner
def values_of(
    canvas: CellGrid, template: Floats, balance: Floats, background_weight: float
) -> Floats:
    """
    Return what each cell is worth to each of n templates, and to someone unknown.

    Foreground of a colour that is more likely another member's is worth nothing, neither for nor
    against.
    """
    known, count = np.empty(len(template), np.int64), 0
    for index in range(len(template)):
        if not is_empty(template[index]):
            known[count] = index
            count += 1
    height, width = canvas.foreground.shape
    values = np.empty((len(template) + 1, height, width))
    for index in range(len(values)):
        for y in range(height):
            for x in range(width):
                foreground = canvas.foreground[y, x]
                values[index, y, x] = foreground * (1.0 + background_weight) - background_weight
    if count < 2:
        return values
    side, likelihood = canvas.width // 2, np.empty(count)
    rows, columns, _ = canvas.colour.shape
    for row in range(rows):
        for column in range(columns):
            y, x = canvas.above + row, side + column
            colour = canvas.colour[row, column]
            bins, shares = colour_shares(balance, colour[0], colour[1], colour[2])
            total = 0.0
            for index in range(count):
                member = known[index]
                own = template[member]  # of either half: it is not known yet where he stands
                likelihood[index] = RARE
                for bin, share in zip(bins, shares):
                    likelihood[index] += share * (own[bin] + own[HALF + bin])
                total += likelihood[index]
            usual = total / count
            for index in range(count):
                member = known[index]
                share = min(likelihood[index] / usual, 1.0)
                values[member, y, x] += canvas.foreground[y, x] * (share - 1.0)
    return values


@inner
def _score_at(
    canvas: CellGrid, value: Floats, cover: Ints, tops: Ints, certainty: float,
    place: tuple[float, float], row: int, column: int, precision: Floats,
) -> float:  # fmt: skip
    """Return the score of one place, given where (2,) in px from it somebody is expected."""
    total, bottom = 0.0, canvas.above + row + 1
    for y in range(tops[row], bottom):
        for x in range(column, column + canvas.width):
            total += value[y, x] if cover[y, x] == 0 else 0.0
    size = (bottom - tops[row]) * canvas.width
    across, down = place
    distance = (
        precision[0, 0] * across * across
        + 2 * precision[0, 1] * across * down
        + precision[1, 1] * down * down
    )
    score: float = certainty * total / size - 0.5 * distance
    return score


@inner
def _reach(
    canvas: CellGrid, value: Floats, cover: Ints, tops: Ints, certainty: float,
    bottom: Floats, precision: Floats,
) -> tuple[int, int, int, int]:  # fmt: skip
    """
    Return the first and last rows and columns of places that may be better than the nearest.

    No cell is worth more than 1, so what lies far away cannot make up for its distance.
    """
    rows, columns = len(tops), value.shape[1] - canvas.width
    scale = precision[0, 0] * precision[1, 1] - precision[0, 1] * precision[1, 0]
    if not scale > 0.0:
        return 0, rows - 1, 0, columns - 1
    across = (bottom[0] - canvas.left) / canvas.step - 0.5
    down = (bottom[1] - canvas.top) / canvas.step - 1.0
    row, column = min(max(round(down), 0), rows - 1), min(max(round(across), 0), columns - 1)
    if canvas.metre[row] == 0.0:
        return 0, rows - 1, 0, columns - 1
    place = (column - across) * canvas.step, (row - down) * canvas.step
    least = _score_at(
        canvas, value, cover, tops, certainty, place, row, column, precision
    )  # fmt: skip
    farthest = 2.0 * (certainty - least) / scale / canvas.step**2 + 1e-6
    high, wide = np.sqrt(farthest * precision[0, 0]), np.sqrt(farthest * precision[1, 1])
    return (
        int(max(math.floor(down - high), 0)),
        int(min(math.ceil(down + high), rows - 1)),
        int(max(math.floor(across - wide), 0)),
        int(min(math.ceil(across + wide), columns - 1)),
    )


@inner
def best_place(
    canvas: CellGrid, value: Floats, cover: Ints, tops: Ints, certainty: float,
    bottom: Floats, precision: Floats,
) -> tuple[int, int, float]:  # fmt: skip
    """Return the best place, row and column, past all that is covered, and its score."""
    height, width = value.shape
    first_row, last_row, first_column, last_column = _reach(
        canvas, value, cover, tops, certainty, bottom, precision
    )
    below = np.zeros((height + 1, width))
    for y in range(height):
        for x in range(first_column, last_column + canvas.width + 1):
            free = value[y, x] if cover[y, x] == 0 else 0.0
            below[y + 1, x] = below[y, x] + free
    best, best_row, best_column = -np.inf, 0, 0
    for row in range(first_row, last_row + 1):
        if canvas.metre[row] == 0.0:
            continue
        first, last = below[tops[row]], below[canvas.above + row + 1]
        size = (canvas.above + row + 1 - tops[row]) * canvas.width
        down = canvas.top + (row + 1) * canvas.step - bottom[1]
        total = 0.0
        for x in range(first_column, first_column + canvas.width):
            total += last[x] - first[x]
        for column in range(first_column, last_column + 1):
            across = canvas.left + (column + 0.5) * canvas.step - bottom[0]
            distance = (
                precision[0, 0] * across * across
                + 2 * precision[0, 1] * across * down
                + precision[1, 1] * down * down
            )
            score = certainty * total / size - 0.5 * distance
            if score > best:
                best, best_row, best_column = score, row, column
            x = column + canvas.width
            total += (last[x] - first[x]) - (last[column] - first[column])
    return best_row, best_column, best


@inner
def add_cover(
    cover: Ints, canvas: CellGrid, tops: Ints, row: int, column: int, number: int
) -> None:
    """Count a body, or with -1 take it away again, on the cells that it covers."""
    for y in range(tops[row], canvas.above + row + 1):
        for x in range(column, column + canvas.width):
            cover[y, x] += number


@inner
def explained(canvas: CellGrid, tops: Ints, row: Ints, column: Ints, order: Ints) -> Floats:
    """Return which share of each body is foreground that none before it in an order covers."""
    share = np.zeros(len(order))
    covered = np.zeros(canvas.foreground.shape, np.bool_)
    for index in order:
        first, last = tops[index, row[index]], canvas.above + row[index] + 1
        for y in range(first, last):
            for x in range(column[index], column[index] + canvas.width):
                if not covered[y, x]:
                    share[index] += canvas.foreground[y, x]
                    covered[y, x] = True
        share[index] /= (last - first) * canvas.width
    return share


@inner
def templates_of(
    image: Bytes, mask: Bytes, canvas: CellGrid, balance: Floats,
    tops: Ints, row: Ints, column: Ints, order: Ints,
) -> Floats:  # fmt: skip
    """Count the colours of what is seen of each body past those before it in an order."""
    owner = np.full(canvas.foreground.shape, -1)
    for place in range(len(order) - 1, -1, -1):
        index = order[place]
        for y in range(tops[index, row[index]], canvas.above + row[index] + 1):
            for x in range(column[index], column[index] + canvas.width):
                owner[y, x] = index
    templates, count = np.zeros((len(order), TEMPLATE_SIZE)), np.zeros(len(order))
    left, top, right, bottom = canvas.part[0], canvas.part[1], canvas.part[2], canvas.part[3]
    rows, columns, _ = canvas.colour.shape
    for y in range(top, bottom, COUNTED_PX):
        line = canvas.above + (y - top) * rows // (bottom - top)
        for x in range(left, right, COUNTED_PX):
            index = owner[line, canvas.width // 2 + (x - left) * columns // (right - left)]
            if index >= 0 and mask[y, x]:
                head, foot = tops[index, row[index]], canvas.above + row[index] + 1
                upper = upper_share((line + 0.5 - head) / (foot - head))
                add_colour(templates[index], upper, balance, image[y, x])
                count[index] += 1.0
    for index in order:
        for bin in range(TEMPLATE_SIZE):
            templates[index, bin] /= max(count[index], 1.0)
    return templates


@inner
def boxes_of(canvas: CellGrid, row: Ints, column: Ints, height_m: Floats) -> Floats:
    """Return left, top, width, height, px, of bodies."""
    box = np.empty((len(row), 4))
    for index in range(len(row)):
        width = canvas.width * canvas.step
        height = canvas.metre[row[index]] * height_m[index] * canvas.step
        box[index, 0] = canvas.left + (column[index] + 0.5) * canvas.step - width / 2
        box[index, 1] = canvas.top + (row[index] + 1) * canvas.step - height
        box[index, 2], box[index, 3] = width, height
    return box


@inner
def lowest_first(row: Floats | Ints) -> Ints:
    """Return the order of rows of the image from the bottom up; equal ones as they come."""
    order = np.arange(len(row))
    for index in range(1, len(row)):
        place = index
        while place and row[order[place - 1]] < row[order[place]]:
            order[place - 1], order[place] = order[place], order[place - 1]
            place -= 1
    return order
