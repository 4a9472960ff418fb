"""Step 5: a silhouette that several established objects share is divided along its length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.silhouettes.features import (
    Floats,
    Ints,
    Mask,
    Shapes,
    best_matches,
    cost,
    stacked,
)
from mctrack_ros.perception.silhouettes.foreground.components import Silhouettes, shapes_of


@dataclass(frozen=True)
class DivisionConfig:
    """Parameters of `partition_merged`."""

    line: str = parameter(
        'objects',
        'line along which silhouettes are divided: as printed, regression of y on x; principal '
        'axis of the pixels; or through the places where the objects are expected',
        choices=('regression', 'principal', 'objects'),
    )
    body_width_m: float = parameter(
        0.9, 'what is no wider and higher than this is one body and not divided [m]', minimum=0.0
    )
    body_height_m: float = parameter(
        2.1, 'the same; 0: everything is divided, as printed [m]', minimum=0.0
    )


def direction(x: Floats, y: Floats, objects: Floats, line: str) -> Floats:
    """
    Return the (2,) unit vector along which a silhouette is divided (eqs (10) and (11)).

    Parameters
    ----------
    x, y : (n,) arrays
        Its pixels.
    objects : (k, 2) array
        Where the objects in it are expected, px.
    line : str
        ``regression``: ``y = a + b x`` by least squares, which an upright silhouette pulls
        towards the horizontal; ``principal``: the axis of largest spread, which is upright where
        two people stand side by side; ``objects``: that of the expected places.

    """
    if line == 'objects':
        x, y = objects.T
    xx, yy = float(np.var(x)), float(np.var(y))
    xy = float(np.mean((x - x.mean()) * (y - y.mean())))
    if line == 'regression':
        angle = np.arctan2(xy, xx) if xx > 0 else np.pi / 2
    else:
        angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    return np.array([np.cos(angle), np.sin(angle)])


def pieces_of(along: Floats, areas: Floats) -> Ints:
    """
    Divide pixels along a line in the proportions of areas (eq. (12)).

    Parameters
    ----------
    along : (n,) array
        Where each pixel is projected to.
    areas : (k,) array
        Of the objects, from left to right, at the time before.

    Returns
    -------
    (n,) int64 array
        Piece of each pixel, 0 to k - 1 from left to right.

    """
    shares = np.cumsum(areas)[:-1] / np.sum(areas)
    mass = np.sort(along)
    last = np.clip(np.ceil(shares * len(along)).astype(int), 1, len(along)) - 1
    return np.searchsorted(mass[last], along, side='left')


def may_be_several(shapes: Shapes, sizes: SizeTable, config: DivisionConfig) -> Mask:
    """Tell which silhouettes, (m,), are larger than one body there, or above the horizon."""
    extent = shapes.box[:, 2:] / sizes.per_metre(sizes.foot_of(shapes.box))
    body = (extent[:, 0] <= config.body_width_m) & (extent[:, 1] <= config.body_height_m)
    return np.asarray(~body)


def partition_merged(
    objects: Shapes,
    silhouettes: Silhouettes,
    shapes: Shapes,
    divisible: Mask,
    match: Mask,
    candidates: Mask,
    config: DivisionConfig,
    weights: Floats,
) -> tuple[Shapes, Mask, Ints]:
    """
    Divide each shared silhouette among its objects if that makes one of them look more alike.

    Parameters
    ----------
    objects : Shapes
        Of n objects, at the time before.
    silhouettes : Silhouettes
        With the pixels.
    shapes : Shapes
        Of its m silhouettes.
    divisible : (m,) bool array
        Which of them may be several bodies.
    match : (n, m) bool array
        The match matrix.
    candidates : (n,) bool array
        Objects among which silhouettes are divided: those that are not transient.
    config : DivisionConfig
        Parameters.
    weights : (21,) array
        Of the comparison.

    Returns
    -------
    shapes : Shapes
        The silhouettes, with the first piece in the place of one that was divided and the others
        at the end.
    match : (n, m + p) bool array
        The match matrix for these.
    origin : (m + p,) int64 array
        Silhouette that each is, or is a piece of.

    """
    origin = np.arange(len(shapes))
    for column in np.flatnonzero((match[candidates].sum(axis=0) > 1) & divisible).tolist():
        rows = np.flatnonzero(match[:, column] & candidates)
        pieces = _divide(objects.select(rows), silhouettes, shapes, column, config)
        taken = _assigned(objects.select(rows), shapes.vector[column], pieces, weights)
        if taken is None:
            continue
        places = np.r_[column, len(shapes) + np.arange(len(rows) - 1)]
        shapes = stacked(shapes.replaced(column, pieces), pieces.select(np.arange(1, len(rows))))
        match = np.pad(match, ((0, 0), (0, len(rows) - 1)))
        match[rows, column] = False
        match[rows, places[taken]] = True
        origin = np.r_[origin, np.full(len(rows) - 1, column)]
    return shapes, match, origin


def _divide(
    objects: Shapes, silhouettes: Silhouettes, shapes: Shapes, column: int, config: DivisionConfig
) -> Shapes:
    """Return the shapes of a silhouette's pieces, from left to right, none empty."""
    left, top, width, height = shapes.box[column].astype(int).tolist()
    window = np.s_[top : top + height, left : left + width]
    y, x = np.nonzero(silhouettes.row_of[silhouettes.labels[window]] == column)
    x, y = x + left, y + top
    line = direction(x.astype(float), y.astype(float), objects.centroid, config.line)
    axis = np.array([1.0, 0.0]) if config.line == 'regression' else line
    order = np.argsort(objects.centroid @ axis, kind='stable')
    piece = pieces_of(x * line[0] + y * line[1], objects.area[order])
    grey = silhouettes.grey[y, x]
    return stacked(
        *(
            shapes_of(x[piece == index], y[piece == index], grey[piece == index])
            for index in range(len(order))
            if (piece == index).any()
        )
    )


def _assigned(objects: Shapes, whole: Floats, pieces: Shapes, weights: Floats) -> Ints | None:
    """
    Return the piece of each object, none twice, or None where no object is better off (eq. (13)).

    In index order, each object takes the piece of lowest cost that is left.
    """
    if len(pieces) < len(objects):
        return None
    taken = np.zeros(len(objects), np.int64)
    free = np.ones((1, len(pieces)), np.bool_)
    better = False
    for row in range(len(objects)):
        target = objects.vector[[row]]
        taken[row] = best_matches(target, pieces.vector, free, weights)[0]
        free[0, taken[row]] = False
        fresh = np.abs(target[0] - pieces.vector[taken[row]])
        better |= cost(fresh, np.abs(target[0] - whole), weights) < 0.0
    return taken if better else None
