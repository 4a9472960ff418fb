"""Parameters that all trackers of fusion have."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.config import parameter
from mctrack_ros.fusion.clock_offsets.config import ClocksConfig

MISSED_IMAGES = 2.5
"""A camera from which nothing came for so many of its intervals has lost two images, not one."""
CORRELATED_S = 0.25
"""Images of one camera within this time are one observation, s: errors of feet last so long."""


@dataclass(frozen=True)
class BatchingConfig:
    """When a tick is closed."""

    period: float = parameter(
        0.04, 'Length of a tick, that of the fastest camera [s]', minimum=0.001, maximum=10.0
    )
    max_wait: float = parameter(
        0.8,
        'Longest wait for a camera after the first arrival [periods]',
        minimum=0.0,
        maximum=100.0,
        at_run_time=True,
    )
    camera_timeout: float = parameter(
        1.0,
        'A camera silent for so long, and for 2.5 periods, is not waited for [s]',
        minimum=0.01,
        maximum=600.0,
    )
    time_sync_limit: float = parameter(
        0.2,
        'Clocks of cameras that differ by up to this are corrected; a camera farther ahead is '
        'left out; 0: clocks are not compared [s]',
        minimum=0.0,
        maximum=60.0,
    )

    @property
    def patience(self) -> float:
        """For how long a camera may be silent and still counts as live, s."""
        return max(self.camera_timeout, MISSED_IMAGES * self.period)


@dataclass(frozen=True)
class FusionConfig:
    """
    Parameters of fusion; each tracker has a subclass of its own.

    Attributes
    ----------
    tracker : str
        Which tracker they are of.

    """

    tracker: str
    batching: BatchingConfig = BatchingConfig()
    clocks: ClocksConfig = ClocksConfig()
