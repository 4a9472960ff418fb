"""All cameras: ticks of detections -> tracks, feedback and events."""

from mctrack_ros.fusion.batcher import Batcher
from mctrack_ros.fusion.config import FusionConfig
from mctrack_ros.fusion.explain.recorder import DecisionRecorder
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.joint_tracker.output import FusionOutput, Gates
from mctrack_ros.fusion.joint_tracker.pipeline import JointTracker
from mctrack_ros.fusion.trackers import (
    FUSION,
    START_TOPIC,
    FusionTracker,
    Joining,
    Startable,
    fusion_method,
    joined,
    open_batcher,
    open_fusion,
    open_recorder,
)
from mctrack_ros.fusion.views import OpenViews, Views

__all__ = [
    'FUSION',
    'START_TOPIC',
    'Batcher',
    'DecisionRecorder',
    'FusionConfig',
    'FusionOutput',
    'FusionTracker',
    'Gates',
    'Joining',
    'JointConfig',
    'JointTracker',
    'OpenViews',
    'Startable',
    'Views',
    'fusion_method',
    'joined',
    'open_batcher',
    'open_fusion',
    'open_recorder',
]
