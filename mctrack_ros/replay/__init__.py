"""Bags through the pipelines in lock step, without DDS."""

from mctrack_ros.replay.lockstep import ReplayError
from mctrack_ros.replay.track import TrackSummary, track_bag

__all__ = [
    'ReplayError',
    'TrackSummary',
    'track_bag',
]
