"""Whether those who are told to wear one kit do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation.frames import ground_distance, matched
from mctrack_ros.interfaces import Tracks, TrackStatus


@dataclass(frozen=True, slots=True)
class KitScore:
    """
    How well kits are told.

    Attributes
    ----------
    found : int
        How many there are.
    purity : float
        Of those whose kit is told, the share that wears what most with that kit do.
    told : float
        Share of all whose kit is told.

    """

    found: int
    purity: float
    told: float


def score_kits(truth: Sequence[Tracks], tracks: Sequence[Tracks], gate_m: float) -> KitScore:
    """
    Hold the kits of tracks against those of the people whom they are matched to.

    Parameters
    ----------
    truth, tracks : sequence of Tracks
        Instants, of which those of one stamp belong together.
    gate_m : float
        Largest distance of a match, m.

    """
    told = {rows.stamp_ns: rows for rows in tracks}
    together = [(rows, told[rows.stamp_ns]) for rows in truth if rows.stamp_ns in told]
    pairs = np.concatenate([np.zeros((0, 2), int), *(_pairs(*both, gate_m) for both in together)])
    known = pairs[pairs[:, 1] > 0]
    count = np.zeros(pairs.max(axis=0, initial=0) + 1, int)
    np.add.at(count, tuple(known.T), 1)
    return KitScore(
        found=len(np.unique(known[:, 1])),
        purity=count.max(axis=0).sum() / max(len(known), 1),
        told=len(known) / max(len(pairs), 1),
    )


def _pairs(truth: Tracks, tracks: Tracks, gate_m: float) -> NDArray[np.int64]:
    """Return the true and the told kit, (n, 2), of each one who is matched."""
    is_reported = (tracks.status != TrackStatus.TENTATIVE) & (tracks.status != TrackStatus.DELETED)
    tracks = tracks.select(is_reported)
    distance = ground_distance(*(rows.position[:, :2].astype(float) for rows in (truth, tracks)))
    true, found = matched(distance, gate_m)
    return np.column_stack([truth.kit[true], tracks.kit[found]]).astype(np.int64)
