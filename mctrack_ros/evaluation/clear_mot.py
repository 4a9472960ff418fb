"""CLEAR MOT and identity scores, by py-motmetrics; detection scores without identity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import motmetrics
import numpy as np

from mctrack_ros.evaluation.frames import Frame, frames_of, ground_distance, matched
from mctrack_ros.evaluation.trajectories import Trajectories

_METRICS = {
    'mota': 'mota',
    'motp': 'mean_distance',
    'idf1': 'idf1',
    'idp': 'idp',
    'idr': 'idr',
    'precision': 'precision',
    'recall': 'recall',
    'num_switches': 'switches',
    'num_false_positives': 'false_positives',
    'num_misses': 'misses',
    'num_fragmentations': 'fragmentations',
    'mostly_tracked': 'mostly_tracked',
    'partially_tracked': 'partially_tracked',
    'mostly_lost': 'mostly_lost',
    'num_unique_objects': 'truth_ids',
    'num_objects': 'truth_rows',
    'num_predictions': 'track_rows',
}
_RATIOS = {'mota', 'mean_distance', 'idf1', 'idp', 'idr', 'precision', 'recall'}


def clear_mot(frames: Sequence[Frame], gate: float) -> dict[str, Any]:
    """
    Score with identity (Bernardin and Stiefelhagen 2008; Ristani et al. 2016).

    A pair that was matched in the frame before stays matched while it is within the gate; only
    the rest is assigned anew. IDF1 is of the best one-to-one assignment of whole tracks.

    Parameters
    ----------
    frames : sequence of Frame
        Truth and tracks.
    gate : float
        Largest distance of a match.

    Returns
    -------
    dict
        ``mota``, ``mean_distance`` of the matches, ``idf1``, ``idp``, ``idr``, ``precision``,
        ``recall``, and counts; NaN where nothing is there to divide by.

    """
    host = motmetrics.metrics.create()
    events = accumulated(frames, gate).events
    values = host.compute(events, metrics=list(_METRICS), return_dataframe=False)
    scores = {ours: float(values[theirs]) for theirs, ours in _METRICS.items()}
    return {name: value if name in _RATIOS else int(value) for name, value in scores.items()}


def accumulated(frames: Sequence[Frame], gate: float) -> Any:
    """Return a `motmetrics.MOTAccumulator` that has seen the frames."""
    accumulator = motmetrics.MOTAccumulator()
    for frame in frames:
        gated = np.where(frame.distance <= gate, frame.distance, np.nan)
        accumulator.update(frame.truth, frame.tracks, gated, frameid=frame.number)
    return accumulator


def detection_scores(
    frames: Sequence[Frame], gate: float, zero_distance: float
) -> dict[str, float]:
    """
    Score without identity (Kasturi et al. 2009), each frame matched for itself.

    ``moda = 1 - (misses + false positives) / truth``. Unlike in `clear_mot` nothing is carried
    over from the frame before, so its misses and false positives can be fewer. ``modp`` is the
    mean of ``1 - distance / zero_distance`` over all matches, pooled: with the gate as that
    distance it is WILDTRACK's (Chavdarova et al. 2018), with 1 for boxes the mean IoU.

    Parameters
    ----------
    frames : sequence of Frame
        Truth and tracks.
    gate : float
        Largest distance of a match.
    zero_distance : float
        Distance at which a match is worth nothing.

    Returns
    -------
    dict
        ``moda`` and ``modp``; NaN without truth and without matches.

    """
    distances = [frame.distance[matched(frame.distance, gate)] for frame in frames]
    pooled = np.concatenate([np.empty(0), *distances])
    truth = sum(len(frame.truth) for frame in frames)
    tracks = sum(len(frame.tracks) for frame in frames)
    wrong = truth + tracks - 2 * len(pooled)
    return {
        'moda': 1.0 - wrong / truth if truth else float('nan'),
        'modp': 1.0 - float(pooled.mean()) / zero_distance if len(pooled) else float('nan'),
    }


def ground_events(
    truth: Trajectories, tracks: Trajectories, gate_m: float
) -> tuple[list[Frame], Any]:
    """Match on the ground; return the frames and a table of what happened in them."""
    frames = frames_of(truth, tracks, 'position', ground_distance, gate_m)
    return frames, accumulated(frames, gate_m).mot_events.reset_index()
