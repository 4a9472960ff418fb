"""What became of a pair of a track and a detection, in words."""

from __future__ import annotations

import numpy as np

from mctrack_ros.interfaces import Candidates, Choice


def fate_of(candidates: Candidates, row: int, gate: float) -> str:
    """Return what became of a pair."""
    choice = Choice(candidates.choice[row])
    if choice == Choice.PASSED_OVER:
        return _why_passed_over(candidates, row)
    return {
        Choice.TAKEN: 'taken',
        Choice.BEYOND: f'too far, the gate is {gate:g}: the other images say so',
        Choice.HIDES: f'hides it, a detection of {candidates.member_count[row] or "several"}',
        Choice.BEGINS: 'begins it',
        Choice.UNUSED: 'not used',
    }[choice]


def _why_passed_over(candidates: Candidates, row: int) -> str:
    taker = taker_of(candidates, row)
    same = (candidates.track_id == candidates.track_id[row]) & (
        candidates.camera == candidates.camera[row]
    )
    same &= (candidates.seconds == candidates.seconds[row]) & (candidates.choice == Choice.TAKEN)
    own = candidates.detection[same].tolist()
    if taker:
        return taker
    if own:
        return f'takes {own[0]} instead'
    if candidates.cost[row] > 0:
        return "likelier nobody's: it costs more than 0"
    return 'not probable enough'


def taker_of(candidates: Candidates, row: int) -> str:
    """Return who takes the detection of a pair; empty: nobody."""
    same = (candidates.camera == candidates.camera[row]) & (
        candidates.detection == candidates.detection[row]
    )
    same &= candidates.seconds == candidates.seconds[row]
    takers = np.flatnonzero(same & (candidates.choice == Choice.TAKEN))
    begins = candidates.track_id[same & (candidates.choice == Choice.BEGINS)].tolist()
    if len(takers):
        taker = takers[0]
        return (
            f'track {candidates.track_id[taker]} takes it '
            f'(probability {candidates.probability[taker]:.3f})'
        )
    return f'track {begins[0]} begins with it' if begins else ''
