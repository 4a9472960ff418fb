"""Vehicles among the blobs of the default tracker: one object each, however large."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.blobs import Blobs
from mctrack_ros.perception.classes import ClassConfig, ClassVotes, looks_like_vehicle
from mctrack_ros.perception.local_tracks import LocalTracks
from mctrack_ros.perception.observations import Observations

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

PROVEN_S = 0.3
"""Whoever has looked like a person for so long is one, also in a blob as large as a vehicle, s."""


class Vehicles:
    """
    Tells vehicles from people by size, and lets them stand where they do.

    Parameters
    ----------
    config : ClassConfig
        Parameters.
    come : bool
        Whether there are vehicles; else all are people.
    usual : (2,) array
        Width and height of a person, m.

    """

    def __init__(self, config: ClassConfig, come: bool, usual: Floats) -> None:
        self._config, self._come, self._usual = config, come, usual
        self._votes = ClassVotes(config)

    def among(self, blobs: Blobs, blob_of: Ints, tracks: LocalTracks) -> Mask:
        """Tell which blobs, (n,), are one vehicle each, given which one each track is in."""
        if not self._come:
            return np.zeros(len(blobs), np.bool_)
        large = looks_like_vehicle(self._extent(blobs), self._config)
        balance = self._votes.balance(tracks.local_id)
        return vehicles_among(blob_of, balance, large, blobs.truncated)

    def stand(self, tracks: LocalTracks, seen: Observations, rows: Mask, blobs: Blobs) -> None:
        """
        Let the tracks of some who are seen, (n,) rows, stand in the middle of their ground.

        Who turns out to be a person stands at his feet again; what is cut off tells neither.
        """
        if not self._come:
            return
        chosen = np.flatnonzero(rows & ~seen.fitted & ~blobs.truncated[seen.blob])
        track = seen.track[chosen]
        covers = seen.depth[chosen].any(axis=1) | tracks.near_px[track].any(axis=1)
        if covers.any():
            chosen = chosen[covers]
            tracks.stand(seen.track[chosen], seen.position[chosen], seen.foot[chosen])

    def classify(
        self, tracks: LocalTracks, seen: Observations, blobs: Blobs, seconds: float
    ) -> None:
        """Let the tracks that are seen as a whole, and alone, say what they are by their size."""
        if not self._come:
            tracks.class_id[:] = ClassCode.PERSON
            return
        whole = ~(seen.fitted | blobs.truncated[seen.blob])
        extent = np.full((len(tracks), 2), np.nan)
        extent[seen.track[whole]] = self._extent(blobs)[seen.blob[whole]]
        kind = self._votes.count(tracks.local_id, extent, np.isfinite(extent[:, 0]), seconds)
        told = self._votes.balance(tracks.local_id) != 0.0
        tracks.class_id[:] = np.where(told, kind, ClassCode.UNKNOWN)

    def _extent(self, blobs: Blobs) -> Floats:
        """Return the (n, 2) widths and heights of blobs, m, as if upright."""
        return np.asarray(blobs.box[:, 2:] / blobs.expected * self._usual)


def vehicles_among(blob_of: Ints, balance: Floats, large: Mask, truncated: Mask) -> Mask:
    """
    Tell which blobs are one vehicle: what is as large as one, and no group of people.

    People who meet were seen apart, a vehicle comes as a whole: through the edge of the picture,
    as one track that never looked like a person.

    Parameters
    ----------
    blob_of : (t,) int array
        Row of the blob that each track is in; -1: none.
    balance : (t,) array
        Of the tracks, see `ClassVotes.balance`.
    large, truncated : (n,) bool arrays
        Which blobs look like a vehicle, and which touch the picture's edge.

    """
    people, known = np.zeros(len(large), np.bool_), np.zeros(len(large), np.bool_)
    inside = blob_of >= 0
    people[blob_of[inside & (balance <= -PROVEN_S)]] = True
    known[blob_of[inside & (balance > 0.0)]] = True
    return np.where(known, large | truncated, large & ~truncated & ~people)
