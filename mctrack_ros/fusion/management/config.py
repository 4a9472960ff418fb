"""Parameters and columns of the management stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter
from mctrack_ros.fusion.columns import Column, Columns
from mctrack_ros.fusion.existence.config import ExistenceConfig


@dataclass(frozen=True)
class ManagementConfig(ExistenceConfig):
    """When a track begins and ends."""

    tentative_time: float = parameter(
        0.15,
        'A tentative track without support for so long ends [s]',
        minimum=0.0,
        maximum=100.0,
        at_run_time=True,
    )
    report_time: float = parameter(
        0.5,
        'A track without support is published for so long at most [s]',
        minimum=0.0,
        maximum=100.0,
        at_run_time=True,
    )
    coast_time: float = parameter(
        1.0,
        'A track without support is kept for so long [s]',
        minimum=0.0,
        maximum=1000.0,
        at_run_time=True,
    )
    most_tracks: int = parameter(
        2000,
        'So many tracks are kept at a time; no more begin',
        minimum=1,
        maximum=100000,
        at_run_time=True,
    )
    merge_distance: float = parameter(
        1.0,
        'Two tracks that cameras hardly tell apart become one when nearer than this [m]',
        minimum=0.0,
        maximum=100.0,
        at_run_time=True,
    )


class ManagementColumns(Columns):
    """
    Names and origins of the tracks.

    Attributes
    ----------
    track_id : (n,) uint32 array
    previous_id : (n,) uint32 array
        Its id before this tick, where that changed; else 0.
    origin : (n,) uint32 array
        Id of the track that it split from; 0: none.
    first_ns : (n,) int64 array
        Stamp of the first detection.

    """

    __slots__ = ()
    track_id = Column(np.uint32)
    previous_id = Column(np.uint32)
    origin = Column(np.uint32)
    first_ns = Column(np.int64)

    def absorb(self, kept: int, dropped: int) -> None:
        """Note whose duplicate it was."""
        self.previous_id[kept] = self.track_id[dropped]
