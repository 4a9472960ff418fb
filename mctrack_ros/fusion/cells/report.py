"""What a cell says of one instant: its tracks, and the colours and corrections of its targets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.inputs import JoinedMessages
from mctrack_ros.interfaces import (
    LARGEST_DISTANCE,
    LARGEST_SPEED,
    LARGEST_VARIANCE,
    Feedback,
    Tracks,
)

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class CellReport(JoinedMessages):
    """
    Both messages of a cell's tick.

    Attributes
    ----------
    tracks : Tracks
        What it publishes.
    feedback : Feedback
        What it tells its cameras: by it the site knows templates, and which ids it has corrected.

    """

    COUNTED = 'tracks'
    tracks: Tracks
    feedback: Feedback


def usable(tracks: Tracks) -> Mask:
    """Return which tracks, (n,), have an id of their own, a state and a true covariance."""
    count = len(tracks)
    first = np.zeros(count, bool)
    first[np.unique(tracks.track_id, return_index=True)[1]] = True
    with np.errstate(invalid='ignore'):
        is_near = (np.abs(tracks.position[:, :2]) <= LARGEST_DISTANCE).all(axis=1)
        is_slow = (np.abs(tracks.velocity) <= LARGEST_SPEED).all(axis=1)
        is_sure = np.abs(tracks.covariance).max(axis=(1, 2), initial=0.0) <= LARGEST_VARIANCE
    is_known = np.asarray(is_near & is_slow & is_sure)
    covariance = np.where(is_known[:, None, None], tracks.covariance, np.eye(4))
    covariance = (covariance + covariance.swapaxes(1, 2)) / 2
    trace = np.trace(covariance, axis1=1, axis2=2)
    is_true = np.linalg.eigvalsh(covariance)[:, 0] > -1e-5 * trace  # of 32 bits
    return np.asarray(first & is_known & is_true & (trace > 0) & (tracks.track_id > 0))


def unusable_count(report: CellReport) -> int:
    """Return how many tracks of a report cannot be used."""
    return int(np.count_nonzero(~usable(report.tracks)))
