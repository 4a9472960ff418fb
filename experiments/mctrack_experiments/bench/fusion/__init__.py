"""Fusion on the shared benchmark: time, accuracy beside other trackers, bad input."""

from mctrack_experiments.bench.fusion.bench import bench_fusion
from mctrack_experiments.bench.fusion.toolkit import (
    INSTALL,
    PEERS,
    installed_peers,
    toolkit_folder,
)

__all__ = [
    'INSTALL',
    'PEERS',
    'bench_fusion',
    'installed_peers',
    'toolkit_folder',
]
