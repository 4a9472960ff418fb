"""Marginal probabilities of the pairs by belief propagation."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_1D, INTS_1D, compiled

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST_ROUNDS = 100
SETTLED = 1e-6
"""Messages are passed on until none changes by more, relative to itself."""
LARGEST = 1e9
"""A likelihood beyond this is as good as certain, and would drown the others in rounding."""


@compiled(types.f8[::1](INTS_1D, INTS_1D, FLOATS_1D))
def beliefs(slot: Indices, detection: Indices, likelihood: Floats) -> Floats:
    """
    Return JPDA's probabilities (k,), approximately, in a time that grows with their number.

    Slots and detections tell each other how free they are (Williams and Lau 2014, "Approximate
    evaluation of marginal association probabilities with belief propagation"); exact where the
    graph has no loops.
    """
    count = len(slot)
    if count == 0:
        return np.zeros(0)
    offered, wanted = np.empty(slot[-1] + 1), np.empty(detection.max() + 1)
    message, likelihood = np.ones(count), np.minimum(likelihood, LARGEST)
    for _ in range(MOST_ROUNDS):
        offered[:], wanted[:] = 1.0, 1.0
        for pair in range(count):
            offered[slot[pair]] += likelihood[pair] * message[pair]
        for pair in range(count):
            own = likelihood[pair] * message[pair]
            wanted[detection[pair]] += likelihood[pair] / (offered[slot[pair]] - own)
        change = 0.0
        for pair in range(count):
            own = likelihood[pair] * message[pair]
            asked = likelihood[pair] / (offered[slot[pair]] - own)
            new = 1.0 / (wanted[detection[pair]] - asked)
            change = max(change, abs(new - message[pair]) / new)
            message[pair] = new
        if change < SETTLED:
            break
    offered[:] = 1.0
    for pair in range(count):
        offered[slot[pair]] += likelihood[pair] * message[pair]
    return likelihood * message / offered[slot]
