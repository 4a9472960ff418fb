"""Detections of the persons in an image, for fusion and inside the camera."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.perception.blob_split.measurements import Observations
from mctrack_ros.perception.blobs.extraction import Blobs
from mctrack_ros.perception.feedback.persons_in_view import ConfirmedTracks
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.table import LocalTracks

LEAST_SCORE = 0.1
LEAST_COLOURED = 0.3
"""Least visible share of a body from which its own colours are used; by trial."""


def confirmed_tracks(seen: Observations, tracks: LocalTracks, stamp_ns: int) -> ConfirmedTracks:
    """Return the confirmed tracks, as the image of a stamp shows them."""
    rows = np.flatnonzero(seen.track >= 0)
    row_of = np.full(len(tracks), -1)
    row_of[seen.track[rows]] = rows
    index = np.flatnonzero(tracks.confirmed)
    row = row_of[index]
    is_seen = row >= 0
    box, own_share = np.zeros((len(index), 4)), np.zeros(len(index))
    box[is_seen], own_share[is_seen] = seen.box[row[is_seen]], seen.own_share[row[is_seen]]
    age_s = np.asarray((stamp_ns - tracks.first_ns[index]) * 1e-9)
    local_id, place = tracks.local_id[index], tracks.mean[index, :2]
    return ConfirmedTracks(local_id, place, box, is_seen, own_share, age_s)


def reported_persons(
    seen: Observations,
    tracks: LocalTracks,
    blobs: Blobs,
    sizes: SizeTable,
    stamp_ns: int,
    confirm_s: float,
) -> dict[str, NDArray[Any]]:
    """
    Return columns of `Detections`, one row a person.

    Parameters
    ----------
    seen : Observations
        The persons, every one with a track.
    tracks : LocalTracks
        The tracks.
    blobs : Blobs
        The foreground that they are in.
    sizes : SizeTable
        Of the camera: who is alone in a whole blob is as large as that.
    stamp_ns : int
        Time of the image, ns.
    confirm_s : float
        Age at which a track is certain, s.

    """
    track, is_cut, size = seen.track, blobs.truncated[seen.blob], seen.box[:, 2:]
    fitted_area = seen.visible * size[:, 0] * size[:, 1]
    age_s = (stamp_ns - tracks.first_ns[track]) * 1e-9
    is_coloured = ~seen.fitted | (seen.visible >= LEAST_COLOURED)
    is_whole = ~seen.fitted & ~is_cut
    extent = size / sizes.per_metre(seen.foot)
    return {
        'position': np.pad(seen.position, ((0, 0), (0, 1))),
        'box': seen.box,
        'area': np.where(seen.fitted, fitted_area, blobs.area[seen.blob]),
        'score': (age_s / confirm_s).clip(LEAST_SCORE, 1.0),
        'extent': np.where(is_whole[:, None], extent, np.nan),
        'template': np.where(is_coloured[:, None], seen.template, tracks.template[track]),
        'local_id': tracks.local_id[track],
        'track_id': tracks.track_id[track],
        'truncated': is_cut,
    }
