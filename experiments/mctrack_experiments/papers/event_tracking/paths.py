"""True and estimated places of each target, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation.frames import frames_of, ground_distance, matched
from mctrack_ros.evaluation.trajectories import Trajectories


@dataclass(frozen=True, eq=False, slots=True)
class MatchedPath:
    """
    Where one target was, and where its track was.

    Attributes
    ----------
    frame : (n,) int64 array
        Those in which it was tracked, ascending.
    true, found : (n, 2) arrays
        Places, m.

    """

    frame: NDArray[np.int64]
    true: NDArray[np.float64]
    found: NDArray[np.float64]

    def correlation(self) -> NDArray[np.float64]:
        """Return those of x and of y (event-tracking paper, section 5.3), (2,)."""
        both = np.asarray(np.corrcoef(np.column_stack([self.true, self.found]).T))
        return np.array([both[0, 2], both[1, 3]])

    def rmse_m(self) -> NDArray[np.float64]:
        """Return the errors over x and y, (2,) m."""
        return np.asarray(np.sqrt(((self.found - self.true) ** 2).mean(axis=0)))


def matched_paths(
    truth: Trajectories, tracks: Trajectories, gate_m: float
) -> dict[int, MatchedPath]:
    """
    Return for each true id where it was and where what is matched to it was.

    Parameters
    ----------
    truth, tracks : Trajectories
        With positions.
    gate_m : float
        Largest distance of a match, m.

    """
    true_rows = {pair: row for row, pair in enumerate(zip(truth.frame, truth.id))}
    rows = {pair: row for row, pair in enumerate(zip(tracks.frame, tracks.id))}
    ids, track_ids = np.unique(truth.id), np.unique(tracks.id)
    pairs: dict[int, list[tuple[int, int, int]]] = {}
    for frame in frames_of(truth, tracks, 'position', ground_distance, gate_m):
        for mine, theirs in zip(*matched(frame.distance, gate_m)):
            person, track = ids[frame.truth[mine]], track_ids[frame.tracks[theirs]]
            pair = true_rows[frame.number, person], rows[frame.number, track]
            pairs.setdefault(int(person), []).append((frame.number, *pair))
    found = {person: np.array(each, np.int64).T for person, each in pairs.items()}
    return {
        person: MatchedPath(frame, truth.position[mine], tracks.position[theirs])
        for person, (frame, mine, theirs) in found.items()
    }


def with_past(tracks: Trajectories, origin: Mapping[int, int]) -> Trajectories:
    """
    Give every track the past of the group from which it split (event-tracking, Definition 6).

    Parameters
    ----------
    tracks : Trajectories
        With positions.
    origin : mapping of int to int
        Track -> the track of which it was part before it began.

    """
    frame, ids, position = [tracks.frame], [tracks.id], [tracks.position]
    for track in np.unique(tracks.id).tolist():
        seen, now, before = {track}, track, tracks.frame[tracks.id == track].min()
        while (now := origin.get(now, track)) not in seen:
            seen.add(now)
            past = (tracks.id == now) & (tracks.frame < before)
            frame.append(tracks.frame[past])
            ids.append(np.full(past.sum(), track))
            position.append(tracks.position[past])
            before = min([before, *tracks.frame[past]])
    return Trajectories(np.concatenate(frame), np.concatenate(ids), np.concatenate(position))
