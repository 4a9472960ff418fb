"""Steps 2 and 4: a silhouette that several objects want goes to the established ones."""

from __future__ import annotations

import numpy as np

from mctrack_ros.perception.silhouettes.features import (
    Floats,
    Ints,
    Mask,
    Shapes,
    best_matches,
)


def secure_silhouettes(match: Mask, established: Mask) -> Mask:
    """Tell which silhouettes, (m,), an established object is matched to: securely matched."""
    return np.asarray(match[established].any(axis=0))


def without_transient_duplicates(match: Mask, established: Mask) -> Mask:
    """
    Take from transient objects the silhouettes that established ones are matched to.

    Parameters
    ----------
    match : (n, m) bool array
        The match matrix.
    established : (n,) bool array
        Objects that were matched before; the others are transient.

    Returns
    -------
    (n, m) bool array
        The match matrix without these.

    """
    lost = ~established[:, None] & secure_silhouettes(match, established)[None]
    return match & ~lost


def settled(objects: Shapes, silhouettes: Shapes, match: Mask, weights: Floats) -> Mask:
    """
    Leave every silhouette to the best of the objects that still share it.

    The paper does not say what becomes of a silhouette that could not be partitioned, or that
    two transient objects are matched to; one observation cannot be two objects.

    Parameters
    ----------
    objects, silhouettes : Shapes
        Of n objects and m silhouettes.
    match : (n, m) bool array
        The match matrix.
    weights : (21,) array
        Of the comparison.

    """
    match = match.copy()
    for column in np.flatnonzero(match.sum(axis=0) > 1).tolist():
        sharing = np.flatnonzero(match[:, column])
        match[sharing, column] = False
        match[best_of(objects, silhouettes, sharing, column, weights), column] = True
    return match


def best_of(objects: Shapes, silhouettes: Shapes, rows: Ints, column: int, weights: Floats) -> int:
    """Return which of some objects is most like a silhouette."""
    target = silhouettes.vector[[column]]
    allowed = np.ones((1, len(rows)), np.bool_)
    winner = best_matches(target, objects.vector[rows], allowed, weights)
    return int(rows[winner[0]])
