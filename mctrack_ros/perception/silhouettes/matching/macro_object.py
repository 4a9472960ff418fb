"""Step 3: whether established objects that want one silhouette have merged in it."""

from __future__ import annotations

import numpy as np

from mctrack_ros.perception.silhouettes.features import (
    NONE,
    Floats,
    Ints,
    Mask,
    Shapes,
    best_matches,
    cost,
)
from mctrack_ros.perception.silhouettes.matching.duplicates import best_of


def resolve_merges(
    objects: Shapes,
    silhouettes: Shapes,
    match: Mask,
    valid: Mask,
    established: Mask,
    weights: Floats,
    divisible: Mask | None = None,
) -> Mask:
    """
    Keep several established objects on one silhouette only if together they look like it.

    Else the one that is most like it keeps it, and the others, in index order, take the best of
    the valid silhouettes that no established object has.

    Parameters
    ----------
    objects, silhouettes : Shapes
        Of n objects and m silhouettes.
    match, valid : (n, m) bool arrays
        The match and valid-match matrices.
    established : (n,) bool array
        Objects that are not transient.
    weights : (21,) array
        Of the comparison.
    divisible : (m,) bool array, optional
        Silhouettes that may be several bodies; no others are shared. Unless given, all.

    Returns
    -------
    (n, m) bool array
        The match matrix; transient objects may have to give way to it (step 4).

    """
    match = match.copy()
    losers: list[int] = []
    for column in np.flatnonzero(match[established].sum(axis=0) > 1).tolist():
        rows = np.flatnonzero(match[:, column] & established)
        shareable = divisible is None or divisible[column]
        if shareable and macro_cost(objects.select(rows), silhouettes.vector[column], weights) < 0:
            continue
        match[rows, column] = False
        keeper = best_of(objects, silhouettes, rows, column, weights)
        match[keeper, column] = True
        losers += [row for row in rows.tolist() if row != keeper]
    _reallocate(np.sort(losers), objects, silhouettes, match, valid, established, weights)
    return match


def macro_cost(objects: Shapes, silhouette: Floats, weights: Floats) -> float:
    """Return the cost of objects as one macro-object against them apart (eqs (8) and (9))."""
    together = np.abs(objects.united().vector[0] - silhouette)
    apart = np.abs(objects.vector - silhouette).sum(axis=0)
    return cost(together, apart, weights)


def _reallocate(
    losers: Ints,
    objects: Shapes,
    silhouettes: Shapes,
    match: Mask,
    valid: Mask,
    established: Mask,
    weights: Floats,
) -> None:
    """Give objects, one after another, the best of what is left; changes the match matrix."""
    for row in losers.tolist():
        free = valid[[row]] & ~np.any(match[established], axis=0, keepdims=True)
        winner = int(best_matches(objects.vector[[row]], silhouettes.vector, free, weights)[0])
        if winner != NONE:
            match[row, winner] = True
