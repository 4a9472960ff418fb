"""Bags through the pipelines in lock step, without DDS."""

from mctrack_ros.replay.camera_source import CameraResult
from mctrack_ros.replay.lockstep import ReplayError, TickOutput, run_lockstep
from mctrack_ros.replay.track import TrackSummary, track_bag

__all__ = [
    'CameraResult',
    'ReplayError',
    'TickOutput',
    'TrackSummary',
    'run_lockstep',
    'track_bag',
]
