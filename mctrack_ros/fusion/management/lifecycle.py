"""When tracks are hidden and deleted, in seconds; `existence/evidence.py` confirms them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import compiled
from mctrack_ros.fusion.config import MISSED_IMAGES
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.table import TRACKS, TrackTable

GONE_EVIDENCE = 5.0
"""What no camera sees, where they usually do see who is there, is published no longer from these
log-odds on that it has gone: chosen on WILDTRACK's boxes and 12 development crowds."""
GROUP_MEMORY_S = 0.2
"""A track has left its group when no camera has seen it in one for so long, s."""

Mask = NDArray[np.bool_]


def silence(table: TrackTable, stamp_ns: int) -> NDArray[np.float64]:
    """Return for how long, (n,) s, nothing has supported each track."""
    return (stamp_ns - table.kept_ns) / 1e9


def is_over(table: TrackTable, stamp_ns: int, config: JointConfig) -> Mask:
    """
    Return the mask of the tracks that end now.

    A confirmed track ends when nothing has supported it for `coast_time`, or when its log-odds
    fall below 0; a tentative one after `tentative_time`.

    One whom a slow camera saw last waits for its next images: a confirmed one for two, a
    tentative one while the latest shows it.
    """
    management, least = config.management, 1.5 * config.batching.period
    tentative_s, confirmed_s = (
        max(management.tentative_time, least),
        max(management.coast_time, least),
    )
    return _is_over(table.fixed, stamp_ns, tentative_s, confirmed_s)


@compiled(types.b1[::1](TRACKS, types.i8, types.f8, types.f8))
def _is_over(tracks: Any, stamp_ns: int, tentative_s: float, confirmed_s: float) -> Mask:
    over = np.empty(len(tracks), np.bool_)
    for row in range(len(tracks)):
        silent_s = (stamp_ns - tracks[row]['kept_ns']) / 1e9
        patience_s = max(confirmed_s, MISSED_IMAGES * tracks[row]['pace_s'])
        if tracks[row]['confirmed']:
            over[row] = silent_s > patience_s or tracks[row]['evidence'] < 0
        else:
            is_awaited = tracks[row]['shown_by'] != 0 and silent_s <= patience_s
            over[row] = silent_s > tentative_s and not is_awaited
    return over


def is_expected(table: TrackTable, stamp_ns: int, config: JointConfig) -> Mask:
    """Return the mask of the tracks whose target may be seen any moment: feedback has them."""
    limit = max(config.management.report_time, 1.5 * config.batching.period)
    return silence(table, stamp_ns) <= np.maximum(limit, 1.5 * table.pace_s)


def is_published(table: TrackTable, stamp_ns: int, config: JointConfig) -> Mask:
    """Return the mask of the published tracks: what has most probably gone is not."""
    return is_expected(table, stamp_ns, config) & (table.missed < GONE_EVIDENCE)


def leave_groups(table: TrackTable, stamp_ns: int) -> None:
    """Forget the group of what has not been seen in one for a while."""
    table.group[stamp_ns - table.group_ns > GROUP_MEMORY_S * 1e9] = 0
