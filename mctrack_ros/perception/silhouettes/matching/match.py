"""Step 1: which silhouettes an object may take, and the one that looks most like it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter
from mctrack_ros.perception.silhouettes.features import (
    NONE,
    Floats,
    Mask,
    Shapes,
    best_matches,
)


@dataclass(frozen=True)
class MatchConfig:
    """Parameters of `valid_matches` and `naive_matches`."""

    radius_px: float = parameter(
        80.0, 'greatest distance of an object from a silhouette that it takes [px]', minimum=1.0
    )
    distance: str = parameter(
        'centroids',
        'what it is measured between; paper: centroids',
        choices=('centroids', 'boxes'),
    )
    pedestrian_m: float = parameter(
        1.2,
        'greatest distance of a known pedestrian; 0: radius_px, as in the paper [m]',
        minimum=0.0,
    )
    pedestrian_mps: float = parameter(
        2.0, 'growth of pedestrian_m with the time since the last match [m/s]', minimum=0.0
    )
    stripe_width: float = parameter(
        1.3,
        'a silhouette this many times wider than a known pedestrian, and lower, is not matched',
        minimum=1.0,
    )
    stripe_height: float = parameter(
        0.5, 'how much lower that is, as a share of the height', minimum=0.0, maximum=1.0
    )
    only_valid: bool = parameter(
        True, 'only silhouettes within the radius compete; false: as printed, all do'
    )


def valid_matches(
    objects: Shapes, silhouettes: Shapes, config: MatchConfig, reach: Floats | None = None
) -> Mask:
    """
    Tell which silhouettes lie within an object's search radius.

    Parameters
    ----------
    objects, silhouettes : Shapes
        Of n objects and m silhouettes.
    config : MatchConfig
        Parameters.
    reach : (n,) array, optional
        Each object's radius, px; unless given, that of the parameters.

    Returns
    -------
    (n, m) bool array
        The valid-match matrix V.

    """
    radius = config.radius_px if reach is None else reach[:, None]
    if config.distance == 'boxes':
        apart = gaps(objects.box, silhouettes.box)
    else:
        apart = objects.centroid[:, None] - silhouettes.centroid[None]
    return np.asarray(np.hypot(apart[..., 0], apart[..., 1]) <= radius)


def naive_matches(
    objects: Shapes, silhouettes: Shapes, valid: Mask, config: MatchConfig, weights: Floats
) -> Mask:
    """
    Match each object to the silhouette of lowest cost, then keep valid matches (eqs (6), (7)).

    Parameters
    ----------
    objects, silhouettes : Shapes
        Of n objects and m silhouettes.
    valid : (n, m) bool array
        The valid-match matrix.
    config : MatchConfig
        Parameters.
    weights : (21,) array
        Of the comparison.

    Returns
    -------
    (n, m) bool array
        The match matrix M: at most one silhouette an object, but a silhouette may have several.

    """
    allowed = valid if config.only_valid else np.ones_like(valid)
    winner = best_matches(objects.vector, silhouettes.vector, allowed, weights)
    match = np.zeros_like(valid)
    rows = np.flatnonzero(winner != NONE)
    match[rows, winner[rows]] = True
    return match & valid


def gaps(first: Floats, second: Floats) -> Floats:
    """Return the (n, m, 2) gaps, px, along x and y between (n, 4) and (m, 4) boxes."""
    low, high = first[:, None, :2], first[:, None, :2] + first[:, None, 2:]
    other_low, other_high = second[None, :, :2], second[None, :, :2] + second[None, :, 2:]
    return np.asarray(np.clip(np.maximum(low - other_high, other_low - high), 0.0, None))
