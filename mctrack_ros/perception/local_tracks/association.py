"""Which blob is which local track: gated assignment, then merges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.compiled import BOOLS_1D, FLOATS_2D, FLOATS_3D, compiled
from mctrack_ros.config import parameter
from mctrack_ros.perception.blobs.extraction import Blobs, shared_area
from mctrack_ros.perception.local_tracks.table import LocalTracks, Prediction
from mctrack_ros.tracking.appearance import bhattacharyya_distance

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
TOO_FAR = 1e6
NOWHERE = -1
SIZE_WEIGHT = 4.0
"""Cost of a height twice or half the predicted, as a squared Mahalanobis distance; by trial."""
INSIDE_SHARE = 0.5  # of a predicted box, in a blob, from which the track may be in it: most of it
ROWS = types.Array(types.i8, 1, 'C')


@dataclass(frozen=True)
class MatchingConfig:
    """Parameters of `match`."""

    gate: float = parameter(
        12.0, 'greatest squared Mahalanobis distance of a foot point', minimum=0.1
    )
    appearance_weight: float = parameter(
        8.0, 'cost of wholly different colours, in squared Mahalanobis distances', minimum=0.0
    )


def match(
    tracks: LocalTracks,
    predicted: Prediction,
    blobs: Blobs,
    template: Floats,
    config: MatchingConfig,
) -> Ints:
    """
    Match predicted tracks to blobs.

    Each blob first takes the track that fits it best; a track left over whose predicted box lies
    in a blob is hidden in it: the blob is a group (event-tracking paper, events E5 and E3).

    Parameters
    ----------
    tracks : LocalTracks
        The camera's tracks.
    predicted : Prediction
        Where they are expected.
    blobs : Blobs
        Of the image.
    template : (n, 48) array
        Colours of the blobs.
    config : MatchingConfig
        Parameters.

    Returns
    -------
    (t,) int64 array
        Row of the blob that each track is in; -1: none.

    """
    colour = bhattacharyya_distance(tracks.template, template)
    cost = _costs(
        predicted.foot,
        predicted.spread,
        predicted.box,
        blobs.foot,
        blobs.box,
        config.appearance_weight * colour,
        config.gate,
    )
    row, column = linear_sum_assignment(cost)
    fits = cost[row, column] < TOO_FAR
    blob_of = np.full(len(tracks), NOWHERE, np.int64)
    blob_of[row[fits]] = column[fits]
    _hide(blob_of, tracks.confirmed, predicted.box, blobs.box)
    return blob_of


@compiled(
    types.f8[:, ::1](FLOATS_2D, FLOATS_3D, FLOATS_2D, FLOATS_2D, FLOATS_2D, FLOATS_2D, types.f8)
)
def _costs(
    foot: Floats,
    spread: Floats,
    box: Floats,
    seen_foot: Floats,
    seen_box: Floats,
    colour: Floats,
    gate: float,
) -> Floats:
    """Return (tracks, blobs) costs, from 0, `TOO_FAR` beyond the gate."""
    cost, distance = np.empty(colour.shape), np.empty(colour.shape)
    least = 0.0
    for track in range(len(foot)):
        xx, xy, yy = spread[track, 0, 0], spread[track, 0, 1], spread[track, 1, 1]
        scale = xx * yy - xy * xy
        height = max(box[track, 3], 1.0)
        for blob in range(len(seen_foot)):
            across = seen_foot[blob, 0] - foot[track, 0]
            down = seen_foot[blob, 1] - foot[track, 1]
            far = (yy * across * across - 2 * xy * across * down + xx * down * down) / scale
            ratio = np.log2(max(seen_box[blob, 3], 1.0) / height)
            distance[track, blob] = far
            cost[track, blob] = far + colour[track, blob] + SIZE_WEIGHT * ratio * ratio
            cost[track, blob] += np.log(scale)
            least = min(least, cost[track, blob])
    for track in range(len(foot)):
        for blob in range(len(seen_foot)):
            near = distance[track, blob] <= gate
            cost[track, blob] = min(cost[track, blob] - least, TOO_FAR) if near else TOO_FAR
    return cost


@compiled(types.void(ROWS, BOOLS_1D, FLOATS_2D, FLOATS_2D))
def _hide(blob_of: Ints, confirmed: Booleans, box: Floats, blob_box: Floats) -> None:
    """Put confirmed tracks without a blob into the blob that covers their predicted box."""
    for track in range(len(blob_of)):
        if blob_of[track] != NOWHERE or not confirmed[track]:
            continue
        most = -1.0
        for blob in range(len(blob_box)):
            shared = shared_area(box[track], blob_box[blob])
            inside = shared / max(box[track, 2] * box[track, 3], 1e-9)
            if inside > most:
                most = inside
                blob_of[track] = blob if inside >= INSIDE_SHARE else NOWHERE
