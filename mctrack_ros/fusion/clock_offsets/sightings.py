"""Which detection of an image is which track's, told from where the tracks are alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import (
    LARGEST_DISTANCE,
    LARGEST_VARIANCE,
    REPORTED,
    Detections,
    Tracks,
)

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

REACH_M = 2.0
"""A detection farther from a track is not its own: with 0.2 s between clocks, 10 m/s."""
ALONE = 2.0
"""The next nearest must be so many times as far, unless the camera knows the track."""
SIGHTING = np.dtype(
    [
        ('track', 'i8'),
        ('camera', 'i8'),
        ('seconds', 'f8'),
        ('place', 'f8', 2),
        ('covariance', 'f8', (2, 2)),
    ]
)
"""Where a camera saw a track, m and m², by its own stamp."""


def sightings(
    tracks: Tracks, detections: Detections, camera: int, begin_ns: int
) -> NDArray[np.void]:
    """
    Return what one image says of the tracks that it shows plainly.

    A track and a detection belong together if each is the other's nearest within `REACH_M`, and
    nothing else is nearly as near. A constant offset of the camera's clock displaces all that it
    sees of a target by the same time, so that mostly stays right.

    Parameters
    ----------
    tracks : Tracks
        At a tick.
    detections : Detections
        Of one image of the tick.
    camera : int
        Index of its camera.
    begin_ns : int
        What times count from, ns.

    Returns
    -------
    (k,) array of `SIGHTING`

    """
    rows, columns = _pairs(tracks, detections)
    found = np.zeros(len(rows), SIGHTING)
    found['track'], found['camera'] = tracks.track_id[rows], camera
    found['seconds'] = (detections.stamp_ns - begin_ns) * 1e-9
    found['place'] = detections.position[columns, :2]
    found['covariance'] = detections.covariance[columns]
    return found


def reported(detections: Detections, camera: int, begin_ns: int) -> NDArray[np.void]:
    """Return what one image says of the tracks that the camera itself names; see `sightings`."""
    (columns,) = np.nonzero(_is_plain(detections) & (detections.track_id > 0))
    found = np.zeros(len(columns), SIGHTING)
    found['track'], found['camera'] = detections.track_id[columns], camera
    found['seconds'] = (detections.stamp_ns - begin_ns) * 1e-9
    found['place'] = detections.position[columns, :2]
    found['covariance'] = detections.covariance[columns]
    return found


def _is_plain(detections: Detections) -> NDArray[np.bool_]:
    """Tell which detections are of one whole target and have a sound place."""
    place, noise = detections.position[:, :2], detections.covariance
    with np.errstate(invalid='ignore'):
        sound = (np.abs(place) < LARGEST_DISTANCE).all(axis=1)
        for axis in range(2):
            sound &= (noise[:, axis, axis] > 0) & (noise[:, axis, axis] < LARGEST_VARIANCE)
        sound &= noise[:, 0, 0] * noise[:, 1, 1] > noise[:, 0, 1] * noise[:, 1, 0]
    plain: NDArray[np.bool_] = sound & (detections.member_count == 1) & (detections.truncated == 0)
    return plain


def _pairs(tracks: Tracks, detections: Detections) -> tuple[Indices, Indices]:
    """Return rows of tracks and of the detections that are theirs."""
    (rows,), (columns,) = (
        np.nonzero(np.isin(tracks.status, REPORTED)),
        np.nonzero(_is_plain(detections)),
    )
    if not len(rows) or not len(columns):
        return rows[:0], columns[:0]
    seconds = (detections.stamp_ns - tracks.stamp_ns) * 1e-9
    expected = tracks.position[rows, :2] + seconds * tracks.velocity[rows]
    apart = np.linalg.norm(
        expected[:, None].astype(np.float64) - detections.position[columns, :2], axis=2
    )
    nearest = apart.argmin(axis=1)
    track = np.arange(len(rows))
    is_mutual = apart.argmin(axis=0)[nearest] == track
    own = apart[track, nearest]
    others = apart.copy()
    others[track, nearest] = np.inf
    next_nearest = np.minimum(others.min(axis=1), others[:, nearest].min(axis=0))
    is_known = detections.track_id[columns[nearest]] == tracks.track_id[rows]
    (kept,) = np.nonzero(is_mutual & (own < REACH_M) & (is_known | (next_nearest > ALONE * own)))
    return rows[kept], columns[nearest[kept]]
