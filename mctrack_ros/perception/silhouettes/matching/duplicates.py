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


def without_parts(
    match: Mask, established: Mask, area: Floats, alone_s: Floats, least_s: float
) -> Mask:
    """
    Take shared silhouettes from objects that were never seen as bodies of their own.

    What enters in pieces becomes several objects, and once whole it would be divided among them
    for good. Beyond the paper.

    Parameters
    ----------
    match : (n, m) bool array
        The match matrix.
    established : (n,) bool array
        Objects that are not transient.
    area : (n,) array
        Of the objects, px²; who is larger than those that stay together is no part of them.
    alone_s : (n,) array
        For how long each was seen whole and alone, s.
    least_s : float
        How long that must be; if it is for none, the longest counts.

    """
    match = match.copy()
    for column in np.flatnonzero(match[established].sum(axis=0) > 1).tolist():
        rows = np.flatnonzero(match[:, column])
        enough = min(least_s, float(alone_s[rows].max()))
        young = alone_s[rows] < enough
        small = area[rows] < area[rows[~young]].sum()
        match[rows[young & small], column] = False
    return match


def without_swollen(match: Mask, pedestrian: Mask, vehicle_like: Mask) -> Mask:
    """
    Take from pedestrians silhouettes that are vehicles'.

    Whoever walks up to a car that drives off would become that car. Beyond the paper.

    Parameters
    ----------
    match : (n, m) bool array
        The match matrix.
    pedestrian : (n,) bool array
        Objects that were seen whole and alone, and are pedestrians.
    vehicle_like : (m,) bool array
        Silhouettes as large as vehicles.

    """
    return match & ~(pedestrian[:, None] & vehicle_like[None])


def without_shrunk(match: Mask, vehicle: Mask, person_like: Mask) -> Mask:
    """
    Take from vehicles silhouettes that are no larger than a pedestrian's.

    Whoever comes into the image where a car has just left it would become that car. Beyond the
    paper.

    Parameters
    ----------
    match : (n, m) bool array
        The match matrix.
    vehicle : (n,) bool array
        Objects that were seen whole and alone, and are vehicles.
    person_like : (m,) bool array
        Silhouettes as small as pedestrians, wholly in the image.

    """
    return match & ~(vehicle[:, None] & person_like[None])


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
