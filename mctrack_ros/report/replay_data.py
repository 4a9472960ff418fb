"""Truth and tracks, thinned and rounded, for the page's replay over the pitch."""

from __future__ import annotations

from typing import Any

import numpy as np

from mctrack_ros.evaluation import Timeline, Trajectories
from mctrack_ros.report.ground_plan import hex_colour, pitch_lines
from mctrack_ros.simulation import LENGTH_M, WIDTH_M

_PER_SECOND = 5


def replay_data(
    truth: Trajectories, tracks: Trajectories, line: Timeline, period_s: float
) -> dict[str, Any]:
    """
    Return what the page's script draws, ready for JSON; positions in whole centimetres.

    Parameters
    ----------
    truth, tracks : Trajectories
        In frames of one period.
    line : Timeline
        For the switches.
    period_s : float
        Period of the frames, s.

    """
    step = max(1, round(1.0 / _PER_SECOND / period_s))
    last = int(max(truth.frame.max(initial=0), tracks.frame.max(initial=0)))
    return {
        'size': [LENGTH_M, WIDTH_M],
        'lines': [np.round(polyline, 2).tolist() for polyline in pitch_lines()],
        'seconds_a_step': step * period_s,
        'steps': last // step + 1,
        'truth': _by_id(truth, step),
        'tracks': _by_id(tracks, step),
        'colours': {int(who): hex_colour(int(who)) for who in np.unique(tracks.id)},
        'switches': np.stack([line.switch_frame / step, line.switch_truth_id], axis=1).tolist(),
    }


def _by_id(rows: Trajectories, step: int) -> dict[int, list[list[int]]]:
    """Return id -> [step, x, y] ..., the time thinned to whole steps."""
    kept = rows.select(rows.frame % step == 0)
    order = np.lexsort((kept.frame, kept.id))
    table = np.column_stack([kept.frame // step, np.round(kept.position * 100)]).astype(int)
    ids, starts = np.unique(kept.id[order], return_index=True)
    parts = np.split(table[order], starts[1:])
    return {who: part.tolist() for who, part in zip(ids.tolist(), parts)}
