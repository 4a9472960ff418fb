"""What is wrong with a transformation grid: points that cannot be where they are said to be."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError, polygon_from
from mctrack_ros.ground.grid.transformation_grid import TransformationGrid

Floats = NDArray[np.float64]
LARGEST_CELL_M = 100.0
"""Side of a cell from which lengths are taken to be in another unit than metres."""
FLAT = 1e-3
"""Least area of a cell, as a share of the square over its longest side."""


def grid_flaws(grid: TransformationGrid) -> Iterator[tuple[int, str]]:
    """
    Yield the index of a cell (-1: the field of view) and what is wrong with it.

    A point has one place and one pixel wherever it is named, the corners of a cell do not lie on
    a line, a cell is not folded in the image and is turned as the others are and as a camera
    above the ground sees it, and no side is longer than `LARGEST_CELL_M`.

    Parameters
    ----------
    grid : TransformationGrid
        As read.

    """
    yield from _contradictions(grid)
    ground, image = _around(grid)
    side = np.linalg.norm(ground - np.roll(ground, 1, axis=1), axis=2).max(axis=1)
    span = np.linalg.norm(image - np.roll(image, 1, axis=1), axis=2).max(axis=1)
    flat_ground, flat_image = abs(_area(ground)) < FLAT * side**2, _flat_quads(image, span)
    for cell in np.flatnonzero(flat_ground | flat_image).tolist():
        where = 'on the ground' if flat_ground[cell] else 'in the image'
        yield cell, f'the points {", ".join(grid.names[cell])} lie on a line {where}'
    for cell in np.flatnonzero(side > LARGEST_CELL_M).tolist():
        yield (
            cell,
            f'a side of the cell is {side[cell]:g} m long, expected at most {LARGEST_CELL_M:g} m: '
            'are the lengths in centimetres or millimetres?',
        )
    yield from _swaps(grid, ground, image)
    if grid.fov is not None:
        try:
            polygon_from(grid.fov, 'the field of view')
        except FieldOfViewError as error:
            yield -1, str(error)


def _contradictions(grid: TransformationGrid) -> Iterator[tuple[int, str]]:
    """Yield points that have two places, or places and pixels that have two names."""
    points: dict[str, tuple[float, ...]] = {}
    names: dict[tuple[str, tuple[float, ...]], str] = {}
    both = np.concatenate([grid.ground, grid.image], axis=2)
    for cell, (labels, rows) in enumerate(zip(grid.names, both.tolist())):
        if len(set(labels)) != len(labels):
            yield cell, f'the cell has a point twice: {", ".join(labels)}'
        for name, row in zip(labels, rows):
            if points.setdefault(name, tuple(row)) != tuple(row):
                yield cell, f'point {name!r} has other coordinates here than in a cell before'
            for what, part in (('place on the ground', row[:2]), ('pixel', row[2:])):
                other = names.setdefault((what, tuple(part)), name)
                if other != name:
                    yield cell, f'points {other!r} and {name!r} have the same {what}'


def _swaps(grid: TransformationGrid, ground: Floats, image: Floats) -> Iterator[tuple[int, str]]:
    if (_senses(ground, image) > 0).all():
        yield (
            0,
            (
                'the ground is mirrored in the image: seen from above, y lies to the left of x; '
                'is the sign of one axis wrong, are x and y swapped, or two of the points?'
            ),
        )
        return
    wrong = _misturned(ground, image)
    if not wrong.any():
        return
    culprits = _swapped_pair(grid, wrong)
    for cell in np.flatnonzero(wrong).tolist():
        hint = f'{culprits[0]!r} and {culprits[1]!r}' if culprits else 'two of them'
        yield (
            cell,
            f'the cell of {", ".join(grid.names[cell])} is folded or turned over in the image: '
            f'are {hint} swapped?',
        )


def _swapped_pair(grid: TransformationGrid, wrong: NDArray[np.bool_]) -> tuple[str, str] | None:
    """Return the two points whose swap mends every cell, if there is just one such pair."""
    names, _, image = grid.named_points()
    place = {name: index for index, name in enumerate(names)}
    index = np.array([[place[name] for name in cell] for cell in grid.names])
    pairs = {
        pair
        for cell in np.flatnonzero(wrong).tolist()
        for pair in combinations(sorted(index[cell].tolist()), 2)
    }
    mending = []
    for one, other in sorted(pairs):
        moved = image.copy()
        moved[[one, other]] = image[[other, one]]
        mended = dataclasses.replace(grid, image=moved[index])
        if not _misturned(*_around(mended)).any():
            mending.append((names[one], names[other]))
    return mending[0] if len(mending) == 1 else None


def _misturned(ground: Floats, image: Floats) -> NDArray[np.bool_]:
    """Tell which cells are folded in the image, or turned otherwise than most."""
    senses = _senses(ground, image)
    usual = np.sign(senses.sum()) or 1.0
    wrong: NDArray[np.bool_] = senses != usual
    return wrong


def _senses(ground: Floats, image: Floats) -> Floats:
    """Return -1 for cells as a camera above sees them, 1 for mirrored, 0 for folded ones."""
    corners = np.stack([np.roll(image, shift, axis=1) for shift in (0, -1, -2)], axis=2)
    first, second = np.diff(corners, axis=2)[:, :, 0], np.diff(corners, axis=2)[:, :, 1]
    turns = np.sign(_outer(first, second))
    sense = np.sign(turns.sum(axis=1))
    folded = (turns != sense[:, None]).any(axis=1)
    senses: Floats = np.where(folded, 0.0, sense * np.sign(_area(ground)))
    return senses


def _around(grid: TransformationGrid) -> tuple[Floats, Floats]:
    """Return the cells' corners in a round: about their middle on the ground, in the image."""
    away = grid.ground - grid.ground.mean(axis=1, keepdims=True)
    order = np.argsort(np.arctan2(away[..., 1], away[..., 0]), axis=1)[..., None]
    return np.take_along_axis(away, order, 1), np.take_along_axis(grid.image, order, 1)


def _flat_quads(image: Floats, span: Floats) -> NDArray[np.bool_]:
    """Tell which cells have all corners near one line, however these are ordered."""
    away = image - image.mean(axis=1, keepdims=True)
    least = np.linalg.svd(away, compute_uv=False)[:, 1]
    flat: NDArray[np.bool_] = least < FLAT * span
    return flat


def _area(corners: Floats) -> Floats:
    """Return the signed areas of (n, k, 2) polygons."""
    area: Floats = _outer(corners, np.roll(corners, -1, axis=1)).sum(axis=1) / 2
    return area


def _outer(one: Floats, other: Floats) -> Floats:
    product: Floats = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return product
