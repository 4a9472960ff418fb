"""Higher order tracking accuracy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.evaluation.frames import Floats, Frame

ALPHAS = np.arange(0.05, 0.99, 0.05)
"""Localisation thresholds that the score is averaged over."""

_EPSILON = np.finfo(np.float64).eps


def hota(frames: Sequence[Frame], zero_distance: float) -> dict[str, float]:
    """
    Score detection and association alike (Luiten et al. 2021, as their TrackEval computes it).

    The similarity of a pair is ``max(0, 1 - distance / zero_distance)``. In each frame pairs are
    matched to maximise similarity times the overlap of their whole tracks; that matching serves
    all thresholds alpha from 0.05 to 0.95.

    Parameters
    ----------
    frames : sequence of Frame
        Truth and tracks.
    zero_distance : float
        Distance at which the similarity is zero.

    Returns
    -------
    dict
        ``hota``, ``deta``, ``assa`` and ``loca``, means over alpha; NaN without truth.

    """
    truth_count = _appearances([frame.truth for frame in frames])
    track_count = _appearances([frame.tracks for frame in frames])
    if not truth_count.sum():
        return dict.fromkeys(('hota', 'deta', 'assa', 'loca'), float('nan'))
    similarity = [np.clip(1.0 - frame.distance / zero_distance, 0.0, None) for frame in frames]
    alignment = _alignment(frames, similarity, truth_count, track_count)
    matches = _matches(frames, similarity, alignment)
    rows = [_at_alpha(alpha, matches, truth_count, track_count) for alpha in ALPHAS]
    deta, assa, loca = np.array(rows).T
    return {
        'hota': float(np.sqrt(deta * assa).mean()),
        'deta': float(deta.mean()),
        'assa': float(assa.mean()),
        'loca': float(loca.mean()),
    }


def _appearances(indices: Sequence[NDArray[np.intp]]) -> Floats:
    return np.bincount(np.concatenate([np.empty(0, np.intp), *indices])).astype(np.float64)


def _alignment(
    frames: Sequence[Frame], similarity: Sequence[Floats], truth: Floats, tracks: Floats
) -> Floats:
    """Return the Jaccard overlap of whole tracks, before any matching, (true ids, track ids)."""
    potential = np.zeros((len(truth), len(tracks)))
    for frame, alike in zip(frames, similarity):
        union = alike.sum(axis=0)[None] + alike.sum(axis=1)[:, None] - alike
        share = np.divide(alike, union, out=np.zeros_like(alike), where=union > _EPSILON)
        potential[np.ix_(frame.truth, frame.tracks)] += share
    either = truth[:, None] + tracks[None] - potential
    return np.divide(potential, either, out=np.zeros_like(potential), where=either > 0)


def _matches(
    frames: Sequence[Frame], similarity: Sequence[Floats], alignment: Floats
) -> tuple[NDArray[np.intp], Floats]:
    """Return the pairs of all frames, (n, 2) indices of ids, and their (n,) similarity."""
    pairs, values = [np.empty((0, 2), np.intp)], [np.empty(0)]
    for frame, alike in zip(frames, similarity):
        score = alignment[np.ix_(frame.truth, frame.tracks)] * alike
        rows, columns = linear_sum_assignment(score, maximize=True)
        pairs.append(np.stack([frame.truth[rows], frame.tracks[columns]], axis=1))
        values.append(alike[rows, columns])
    return np.concatenate(pairs), np.concatenate(values)


def _at_alpha(
    alpha: float,
    matches: tuple[NDArray[np.intp], Floats],
    truth: Floats,
    tracks: Floats,
) -> tuple[float, float, float]:
    """Return detection, association and localisation accuracy at one threshold."""
    pairs, similarity = matches
    kept = similarity >= alpha - _EPSILON
    hits = int(kept.sum())
    if not hits:
        return 0.0, 0.0, 1.0
    together = np.zeros((len(truth), len(tracks)))
    np.add.at(together, (pairs[kept, 0], pairs[kept, 1]), 1.0)
    either = np.maximum(1.0, truth[:, None] + tracks[None] - together)
    association = float((together * together / either).sum()) / hits
    detection = hits / (float(truth.sum() + tracks.sum()) - hits)
    return detection, association, float(similarity[kept].mean())
