"""What a pair of a track and a detection costs beside their distance."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    COLUMN_FLAGS,
    COLUMN_SINGLES_2D,
    INTS_1D,
    compiled,
)
from mctrack_ros.fusion.association.config import JointAssociationConfig
from mctrack_ros.fusion.measurements.admission import ROWS
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TRACKS, TrackTable

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Templates = NDArray[np.float32]
Mask = NDArray[np.bool_]
_TEMPLATES = types.Array(types.f4, 2, 'C', readonly=True)

TENTATIVE_COST = 4.0
"""What a track that is not confirmed costs more, -2 log: without it the terrace loses .16 MOTA."""
RARELY_FALSE = 0.2
"""Share of `false_density` that is left where a camera's own tracker vouches for the detection,
and for a track that nobody has looked for. Without the first the terrace by two videos loses .02
MOTA and .05 IDF1; without the second people lose their ids over a time without images."""
UNWATCHED_NS = 700_000_000
"""Time after which what was not seen counts as not looked for, though no camera missed it, ns."""


def prior_costs(
    table: TrackTable,
    batch: Batch,
    track: Indices,
    detection: Indices,
    config: JointAssociationConfig,
) -> Floats:
    """
    Return the (k,) costs of pairs of tracks and single detections of a tick.

    Minus twice the logarithm of a likelihood ratio, "this target's" against "nobody's", but for
    the density of the position: appearance, how sure the track is, and clutter.
    """
    row = batch.single[detection]
    parts = cost_parts(table, batch, track, row, config)
    return parts['appearance'] + parts['doubt'] + parts['clutter']


def cost_parts(
    table: TrackTable, batch: Batch, track: Indices, row: Indices, config: JointAssociationConfig
) -> dict[str, Floats]:
    """
    Return the costs (k,) of tracks and detections, (k,) rows each, by term.

    What false detections cost (clutter) is for each unit of area of a pair's uncertainty.
    """
    rare = _rarely_false(batch.rows, table.fixed, track, row)
    density = config.false_density * np.where(rare, RARELY_FALSE, 1.0)
    return {
        'appearance': _appearance_costs(table, batch, track, row, config),
        'doubt': np.where(table.confirmed[track], 0.0, TENTATIVE_COST),
        'clutter': 2 * np.log(2 * np.pi * density),
    }


def _appearance_costs(
    table: TrackTable, batch: Batch, track: Indices, row: Indices, config: JointAssociationConfig
) -> Floats:
    """Return what pairs (k,) cost by how unlike they are."""
    if not batch.has_templates:
        return np.zeros(len(track))
    difference = differences(
        table.template,
        batch.detections.template,
        batch.is_described,
        track,
        row,
        config.usual_difference,
    )
    return config.appearance_weight * difference


@compiled(types.b1[::1](ROWS, TRACKS, INTS_1D, INTS_1D))
def _rarely_false(rows: Any, tracks: Any, track: Indices, row: Indices) -> Mask:
    """Tell of pairs, (k,), whether a camera's tracker vouches or nobody has looked."""
    local_id, stamp_ns = rows['local_id'], rows['stamp_ns']
    seen_ns, missed = tracks['seen_ns'], tracks['missed']
    rare = np.empty(len(track), np.bool_)
    for pair in range(len(track)):
        own, one = track[pair], row[pair]
        is_unwatched = stamp_ns[one] - seen_ns[own] > UNWATCHED_NS and missed[own] == 0.0
        rare[pair] = local_id[one] > 0 or is_unwatched
    return rare


@compiled(types.f8[::1](COLUMN_SINGLES_2D, _TEMPLATES, COLUMN_FLAGS, INTS_1D, INTS_1D, types.f8))
def differences(
    ours: Templates,
    theirs: Templates,
    is_described: Mask,
    track: Indices,
    row: Indices,
    usual: float,
) -> Floats:
    """
    Return how much more than usual, (k,), templates of tracks and of detections differ.

    0 where one has none; detections are described or not.

    """
    difference = np.zeros(len(track))
    for pair in range(len(track)):
        if is_described[row[pair]] and ours[track[pair]].any():
            alike = 0.0
            for bin in range(ours.shape[1]):
                one, other = ours[track[pair], bin], theirs[row[pair], bin]
                alike += np.sqrt(max(one, 0.0) * max(other, 0.0))
            difference[pair] = min(max(1.0 - alike, 0.0), 1.0) - usual
    return difference
