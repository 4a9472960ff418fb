"""Whether tracks go on, judged without truth."""

from __future__ import annotations

import numpy as np

from mctrack_ros.evaluation.trajectories import Trajectories

REACH_M = 1.5
CLEAR_M = 2.0


def isolated_breaks(tracks: Trajectories, gap_frames: int) -> int:
    """
    Count tracks that end and go on under another id though nobody else is near.

    Parameters
    ----------
    tracks : Trajectories
        With positions.
    gap_frames : int
        The other id begins at most so many frames later, and at most 1.5 m away; nobody else is
        within 2 m when the first one ends.

    """
    order = np.lexsort((tracks.frame, tracks.id))
    ids, frame, place = tracks.id[order], tracks.frame[order], tracks.position[order]
    begins = np.flatnonzero(np.diff(ids, prepend=-1))
    ends = np.flatnonzero(np.diff(ids, append=-1))
    count = 0
    for end in ends.tolist():
        later = frame[begins] - frame[end]
        near = np.linalg.norm(place[begins] - place[end], axis=1) <= REACH_M
        others = (frame == frame[end]) & (ids != ids[end])
        crowded = np.linalg.norm(place[others] - place[end], axis=1) <= CLEAR_M
        goes_on = (later > 0) & (later <= gap_frames) & near
        count += bool(goes_on.any() and not crowded.any())
    return count
