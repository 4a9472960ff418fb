"""When tracks are hidden and deleted, in seconds; `existence/evidence.py` confirms them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.config import MISSED_IMAGES
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.table import TrackTable

GONE_EVIDENCE = 5.0
"""What no camera sees, where they usually do see who is there, is published no longer from these
log-odds on that it has gone: chosen on WILDTRACK's boxes and 12 development crowds."""
GROUP_MEMORY_S = 0.2
"""A track has left its group when no camera has seen it in one for so long, s."""

Mask = NDArray[np.bool_]


def silence(table: TrackTable, stamp_ns: int) -> NDArray[np.float64]:
    """Return for how long, (n,) s, nothing has supported each track."""
    return (stamp_ns - table.kept_ns) / 1e9


def patience(table: TrackTable, config: JointConfig) -> NDArray[np.float64]:
    """
    Return for how long, (n,) s, nothing may support each track before it ends.

    A confirmed track waits `coast_time`, a tentative one `tentative_time`. One whom a slow camera
    saw last waits for its next images: a confirmed one for two, a tentative one while the latest
    shows it.
    """
    management, least = config.management, 1.5 * config.batching.period
    awaited_s = np.maximum(max(management.coast_time, least), MISSED_IMAGES * table.pace_s)
    tentative_s = max(management.tentative_time, least)
    is_shown = table.shown_by != 0
    unsure_s = np.where(is_shown, np.maximum(tentative_s, awaited_s), tentative_s)
    return np.where(table.confirmed, awaited_s, unsure_s)


def is_over(table: TrackTable, stamp_ns: int, config: JointConfig) -> Mask:
    """Return the mask of the tracks that end now: without support or, confirmed, evidence."""
    has_gone = table.confirmed & (table.evidence < 0)
    return (silence(table, stamp_ns) > patience(table, config)) | has_gone


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
