"""Fusion on the shared benchmark: time, accuracy beside other trackers, bad input."""

from mctrack_ros.experiments.fusion_bench.accuracy import HELD_OUT
from mctrack_ros.experiments.fusion_bench.bench import bench_fusion
from mctrack_ros.experiments.fusion_bench.toolkit import (
    INSTALL,
    PEERS,
    installed_peers,
    toolkit_folder,
)

__all__ = [
    'HELD_OUT',
    'INSTALL',
    'PEERS',
    'bench_fusion',
    'installed_peers',
    'toolkit_folder',
]
