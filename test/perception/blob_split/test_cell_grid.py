import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mctrack_ros.perception.blob_split.cell_grid import (
    CellGrid,
    add_cover,
    best_place,
    explained,
    lowest_first,
)

ABOVE, WIDTH, STEP = 4, 3, 2.0


def canvas_like(rng, rows, columns):
    foreground = np.zeros((ABOVE + rows, columns + WIDTH))
    foreground[ABOVE:, 1 : 1 + columns] = rng.random((rows, columns))
    colour, metre = np.zeros((rows, columns, 3)), np.full(rows, 2.0)
    return CellGrid(
        foreground, colour, metre, ABOVE, WIDTH, 10.0, 20.0, STEP, np.array([0, 0, columns, rows])
    )


def bodies(canvas, tops):
    """Yield every place with the part of the canvas that a body there covers."""
    for row, top in enumerate(tops):
        for column in range(canvas.foreground.shape[1] - WIDTH):
            yield row, column, np.s_[top : ABOVE + row + 1, column : column + WIDTH]


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32), st.integers(1, 9), st.integers(1, 9))
def test_best_place_is_that_of_trying_all_places(seed, rows, columns):
    rng = np.random.default_rng(seed)
    canvas = canvas_like(rng, rows, columns)
    value = np.minimum(rng.normal(size=canvas.foreground.shape), 1.0)
    cover = np.zeros(canvas.foreground.shape, int)
    tops = np.array([rng.integers(row, ABOVE + row + 1) for row in range(rows)])
    add_cover(cover, canvas, tops, rng.integers(rows), rng.integers(columns), 1)
    bottom, precision = rng.normal([14, 24], 15), np.diag(5 * rng.random(2)) + 0.1
    expected = -np.inf
    for row, column, part in bodies(canvas, tops):
        away = np.array([10 + (column + 0.5) * STEP, 20 + (row + 1) * STEP]) - bottom
        worth = np.where(cover[part] == 0, value[part], 0.0).mean()
        expected = max(expected, 12.0 * worth - 0.5 * away @ precision @ away)
    row, column, score = best_place(canvas, value, cover, tops, 12.0, bottom, precision)
    assert 0 <= row < rows
    assert 0 <= column < columns
    assert np.isclose(score, expected)


def test_each_body_explains_what_none_before_it_covers():
    canvas = canvas_like(np.random.default_rng(3), 8, 8)
    tops = np.maximum(np.arange(8) + ABOVE - 4, 0)[None].repeat(3, axis=0)
    row, column = np.array([6, 5, 7]), np.array([2, 3, 2])
    order = lowest_first(row)
    assert order.tolist() == [2, 0, 1]
    share = explained(canvas, tops, row, column, order)
    free = np.ones(canvas.foreground.shape, bool)
    for index in order:
        top, bottom = tops[index, row[index]], ABOVE + row[index] + 1
        part = np.s_[top:bottom, column[index] : column[index] + WIDTH]
        assert np.isclose(share[index], (canvas.foreground[part] * free[part]).mean())
        free[part] = False
