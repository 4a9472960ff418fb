"""Identity switches of CLEAR MOT one by one: when, and between whom."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation.clear_mot import ground_events
from mctrack_ros.evaluation.trajectories import Trajectories


@dataclass(frozen=True, eq=False, slots=True)
class Switches:
    """
    Identity switches, in the order of their frames.

    Attributes
    ----------
    frame, last_frame : (n,) int64 arrays
        When a target was first matched with its new track, and last with its old one.
    truth_id : (n,) int64 array
        The target.
    old_id, new_id : (n,) int64 arrays
        The tracks.
    position : (n, 2) float64 array
        Where the target was, m.

    """

    frame: NDArray[np.int64]
    last_frame: NDArray[np.int64]
    truth_id: NDArray[np.int64]
    old_id: NDArray[np.int64]
    new_id: NDArray[np.int64]
    position: NDArray[np.float64]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.frame)


def identity_switches(truth: Trajectories, tracks: Trajectories, gate_m: float) -> Switches:
    """
    List the switches that `evaluate_ground` counts (Bernardin and Stiefelhagen 2008).

    Parameters
    ----------
    truth, tracks : Trajectories
        With positions.
    gate_m : float
        Largest distance of a match, m.

    """
    _, events = ground_events(truth, tracks, gate_m)
    pairs = events[events.Type.isin(['MATCH', 'SWITCH'])]
    former = pairs.groupby('OId')[['HId', 'FrameId']].shift()
    is_switch = (pairs.Type == 'SWITCH').to_numpy(bool)
    switches, former = pairs[is_switch], former[is_switch]
    truth_ids, track_ids = np.unique(truth.id), np.unique(tracks.id)
    who = truth_ids[switches.OId.to_numpy(np.int64)]
    frame = switches.FrameId.to_numpy(np.int64)
    rows = [np.flatnonzero((truth.frame == f) & (truth.id == i))[0] for f, i in zip(frame, who)]
    return Switches(
        frame=frame,
        last_frame=former.FrameId.to_numpy(np.int64),
        truth_id=who,
        old_id=track_ids[former.HId.to_numpy(np.int64)],
        new_id=track_ids[switches.HId.to_numpy(np.int64)],
        position=truth.position[np.array(rows, np.intp)],
    )


def while_isolated(
    switches: Switches, truth: Trajectories, apart_m: float, before: int
) -> NDArray[np.bool_]:
    """
    Tell which targets were alone when they were given another track.

    Parameters
    ----------
    switches : Switches
        Of n.
    truth : Trajectories
        Of all targets.
    apart_m : float
        Nobody else may be nearer than this, m.
    before : int
        From so many frames before the last match with the old track to the first with the new one.

    Returns
    -------
    (n,) bool array

    """
    alone = np.ones(len(switches), np.bool_)
    for row, (first, last, who) in enumerate(
        zip(switches.last_frame - before, switches.frame, switches.truth_id)
    ):
        near = truth.select((truth.frame >= first) & (truth.frame <= last))
        own = near.id == who
        others = near.select(~own)
        for frame, place in zip(near.frame[own], near.position[own]):
            gap = np.linalg.norm(others.position[others.frame == frame] - place, axis=1)
            alone[row] &= bool((gap >= apart_m).all())
    return alone
