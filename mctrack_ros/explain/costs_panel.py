"""What the candidates of a track cost, part by part, as bars."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mctrack_ros.explain.fates import fate_of
from mctrack_ros.explain.history import TrackHistory
from mctrack_ros.explain.words import row_of
from mctrack_ros.interfaces import Candidates, Choice

PARTS = {
    'squared_distance': ('distance²', '#4c6a92'),
    'clutter': ('clutter', '#c9ced6'),
    'appearance': ('colours', '#d98324'),
    'doubt': ('doubt', '#a23b3b'),
}
MOST = 14
"""Number of candidates that are shown: the most probable."""


def draw_costs(axes: Axes, history: TrackHistory, camera_colour: Callable[[int], str]) -> None:
    """Draw a bar a candidate, the camera's name in its colour, and what became of it."""
    candidates, decisions = history.now.candidates, history.now.decisions
    name = decisions.track_id[row_of(decisions, history.track_id)]
    weighed = (candidates.choice <= Choice.TAKEN) & np.isfinite(candidates.cost)
    rows = np.flatnonzero((candidates.track_id == name) & weighed)
    if not len(rows):
        axes.set_axis_off()
        axes.text(0.0, 0.95, f'No detection was weighed for track {name}.', va='top')
        return
    rows = np.sort(rows[np.argsort(-candidates.probability[rows], kind='stable')][:MOST])
    left = _draw_bars(axes, candidates, rows)
    for index, row in enumerate(rows.tolist()):
        text = f'{candidates.probability[row]:.3f}  {fate_of(candidates, row, history.gate)}'
        axes.text(left, index - 0.3, text, fontsize=8.5, va='bottom')
    names = [
        f'{history.cameras[candidates.camera[row]]} {candidates.detection[row]}' for row in rows
    ]
    axes.set_yticks(np.arange(len(rows)), names)
    for tick, row in zip(axes.get_yticklabels(), rows.tolist()):
        tick.set(color=camera_colour(int(candidates.camera[row])), fontweight='bold')
    _describe(axes, len(rows))


def _draw_bars(axes: Axes, candidates: Candidates, rows: NDArray[np.intp]) -> float:
    """Draw the parts of the costs, one bar each of (k,) candidates; return the left end of all."""
    place = np.arange(len(rows))
    low, high = np.zeros(len(rows)), np.zeros(len(rows))
    for part, (label, colour) in PARTS.items():
        values = getattr(candidates, part)[rows].astype(np.float64)
        if values.any():
            start = np.where(values < 0, low, high)
            axes.barh(place, values, 0.4, start, color=colour, label=label)
            low, high = low + np.minimum(values, 0.0), high + np.maximum(values, 0.0)
    axes.plot(candidates.cost[rows], place, 'k|', ms=15, mew=2.5, label='sum')
    axes.axvline(0.0, color='black', lw=0.8)
    return min(float(low.min()), -1.0)


def _describe(axes: Axes, count: int) -> None:
    """Name the axis and the panel of so many candidates."""
    axes.set_ylim(max(count, 4) - 0.3, -0.8)
    axes.set_xlabel("-2 log of the likelihood ratio: the further left, the likelier the track's")
    axes.set_title('Candidates: probability, what became of them, costs', fontsize=10, loc='left')
    axes.spines[['top', 'right']].set_visible(False)
    axes.legend(fontsize=8.5, loc='upper left', bbox_to_anchor=(-0.05, -0.09), ncols=3)
