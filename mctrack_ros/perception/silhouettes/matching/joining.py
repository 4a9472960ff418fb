"""Steps 6 and 7: fragments join the silhouette of an object that looks more like the whole."""

from __future__ import annotations

import numpy as np

from mctrack_ros.perception.silhouettes.features import Floats, Ints, Mask, Shapes, cost


def join_fragments(
    objects: Shapes,
    shapes: Shapes,
    match: Mask,
    valid: Mask,
    joiners: Mask,
    fragments: Mask,
    weights: Floats,
) -> tuple[Shapes, Mask, Ints]:
    """
    Join fragments to objects' silhouettes while that lowers the cost (eq. (14)).

    Parameters
    ----------
    objects, shapes : Shapes
        Of n objects and m silhouettes.
    match, valid : (n, m) bool arrays
        The match and valid-match matrices.
    joiners : (n,) bool array
        Objects that may take fragments: established ones in step 6, transient ones in step 7.
        Those without a silhouette of their own take none.
    fragments : (m,) bool array
        Silhouettes that may be taken: those without a secure match.
    weights : (21,) array
        Of the comparison.

    Returns
    -------
    shapes : Shapes
        The silhouettes that are left, joined.
    match : (n, k) bool array
        Their match matrix; who was matched to a fragment that was taken has lost it.
    kept : (k,) int64 array
        Which of the silhouettes these are.

    """
    taken, match = np.zeros(len(shapes), np.bool_), match.copy()
    for row in np.flatnonzero(joiners & match.any(axis=1)).tolist():
        own = int(match[row].argmax())
        if not match[row, own]:  # somebody took it
            continue
        for other in np.flatnonzero(valid[row] & fragments & ~taken).tolist():
            if other == own:
                continue
            joined = shapes.select(np.array([own, other])).united()
            target = objects.vector[row]
            fresh = np.abs(target - joined.vector[0])
            if cost(fresh, np.abs(target - shapes.vector[own]), weights) < 0.0:
                shapes = shapes.replaced(own, joined)
                taken[other], match[:, other] = True, False
    kept = np.flatnonzero(~taken)
    return shapes.select(kept), match[:, kept], kept
