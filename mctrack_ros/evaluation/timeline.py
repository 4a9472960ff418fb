"""How the comparison with truth went, frame by frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation.clear_mot import ground_events
from mctrack_ros.evaluation.frames import Frame
from mctrack_ros.evaluation.trajectories import Trajectories


@dataclass(frozen=True, eq=False, slots=True)
class Timeline:
    """
    Counts and errors over time, and the switches of identity.

    Attributes
    ----------
    frame : (n,) int64 array
        Every frame that has truth or tracks, ascending.
    truth, tracks, matched : (n,) int64 arrays
        True targets, tracks, and pairs of them within the gate.
    duplicates : (n,) int64 array
        Unmatched tracks within the gate of a true target that has another; the other unmatched
        ones stand where nobody is.
    error_m : (n,) float64 array
        Mean distance of the pairs, m; NaN without any.
    switch_frame, switch_truth_id, switch_track_id : (k,) int64 arrays
        When a true target changed to which track.

    """

    frame: NDArray[np.int64]
    truth: NDArray[np.int64]
    tracks: NDArray[np.int64]
    matched: NDArray[np.int64]
    duplicates: NDArray[np.int64]
    error_m: NDArray[np.float64]
    switch_frame: NDArray[np.int64]
    switch_truth_id: NDArray[np.int64]
    switch_track_id: NDArray[np.int64]


def ground_timeline(truth: Trajectories, tracks: Trajectories, gate_m: float) -> Timeline:
    """
    Match as `evaluate_ground` does for CLEAR MOT; return what happened when.

    Parameters
    ----------
    truth, tracks : Trajectories
        With positions.
    gate_m : float
        Largest distance of a match, m.

    """
    frames, events = ground_events(truth, tracks, gate_m)
    numbers = np.array([frame.number for frame in frames], np.int64)
    switches = events[events.Type == 'SWITCH']
    pairs = events[events.Type.isin(['MATCH', 'SWITCH'])]
    place = np.searchsorted(numbers, pairs.FrameId.to_numpy(np.int64))
    matched = np.bincount(place, minlength=len(numbers))
    total = np.bincount(place, pairs.D.to_numpy(np.float64), minlength=len(numbers))
    error = np.divide(total, matched, out=np.full(len(numbers), np.nan), where=matched > 0)
    return Timeline(
        frame=numbers,
        truth=np.array([len(frame.truth) for frame in frames], np.int64),
        tracks=np.array([len(frame.tracks) for frame in frames], np.int64),
        matched=matched,
        duplicates=_duplicates(frames, events, gate_m),
        error_m=error,
        switch_frame=switches.FrameId.to_numpy(np.int64),
        switch_truth_id=np.unique(truth.id)[switches.OId.to_numpy(np.int64)],
        switch_track_id=np.unique(tracks.id)[switches.HId.to_numpy(np.int64)],
    )


def _duplicates(frames: Sequence[Frame], events: Any, gate_m: float) -> NDArray[np.int64]:
    """Return how many false positives of each frame lie within the gate of a true target."""
    wrong = events[events.Type == 'FP']
    by_frame = wrong.groupby('FrameId').HId.apply(lambda ids: ids.to_numpy(np.int64)).to_dict()
    counts = []
    for frame in frames:
        unmatched = np.isin(frame.tracks, by_frame.get(frame.number, ()))
        near = (frame.distance[:, unmatched] <= gate_m).any(axis=0)
        counts.append(int(near.sum()))
    return np.array(counts, np.int64)
