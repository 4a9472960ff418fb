"""Parameters of the fusion of cells."""

from __future__ import annotations

from dataclasses import dataclass

from mctrack_ros.config import parameter, tag
from mctrack_ros.fusion.config import BatchingConfig, FusionConfig


@dataclass(frozen=True)
class CellsBatchingConfig(BatchingConfig):
    """When a tick is closed: cells answer later than cameras, and not all equally late."""

    max_wait: float = parameter(
        5.0,
        'Longest wait for a cell after the first arrival [periods]',
        minimum=0.0,
        maximum=100.0,
    )


@dataclass(frozen=True)
class CellsConfig(FusionConfig):
    """Parameters of `CellTracker`."""

    tracker: str = tag('cells')
    batching: CellsBatchingConfig = CellsBatchingConfig()
    cell_sigma: float = parameter(
        0.2,
        "Error that all tracks of a cell share beside their own covariance, by its cameras' "
        'calibration [m]',
        minimum=0.001,
        maximum=100.0,
    )
    report_time: float = parameter(
        1.0,
        'A target that no cell has is published for so long at most [s]',
        minimum=0.0,
        maximum=100.0,
    )
    lost_time: float = parameter(
        10.0,
        'A target that no cell has may come out in another one for so long [s]',
        minimum=0.0,
        maximum=1000.0,
    )
