"""Who of those near looks most like a detection, whatever others' pixels are among its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.config import JointAssociationConfig
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TrackTable

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST = 16.0
"""What it costs at most to be unlike: other evidence must be able to outweigh it."""
OVERLAPPED_SHARE = 0.5
"""What is left of it where boxes overlap: some of the pixels are another's."""


def likeness_costs(
    table: TrackTable,
    batch: Batch,
    track: Indices,
    row: Indices,
    is_known: NDArray[np.bool_],
    config: JointAssociationConfig,
) -> Floats:
    """
    Return what pairs of tracks and detections, (k,) rows each, cost by colours that are known.

    Minus twice the logarithm of the likelihood against that of the confirmed track that looks
    most like the detection: it tells people apart and is silent on whether it is one of them.
    The likelihood of a difference is Cauchy-like, so that it tells the less the more of the
    pixels are another's; differences are measured in what people differ from themselves by.
    """
    cost = np.zeros(len(track))
    if config.likeness_weight == 0.0 or not is_known.any():
        return cost
    theirs, ours = batch.detections.template, table.template
    track, row = track[is_known], row[is_known]
    seen = batch.gallery.whitened(np.sqrt(np.maximum(theirs, 0.0)).astype(np.float64))
    change = seen[row] - batch.gallery.drawn(table.track_id, ours)[track]
    difference = np.log1p((change**2).sum(axis=1))
    best = np.full(len(theirs), np.inf)
    sure = table.confirmed[track]
    np.minimum.at(best, row[sure], difference[sure])
    weight = np.where(batch.is_overlapped[row], OVERLAPPED_SHARE, 1.0) * config.likeness_weight
    lead = np.maximum(difference - np.minimum(best[row], difference), 0.0)
    cost[is_known] = np.minimum(weight * lead, MOST)
    return cost
