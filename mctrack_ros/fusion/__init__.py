"""All cameras: ticks of detections -> tracks, feedback and events."""

from mctrack_ros.fusion.batcher import Batcher
from mctrack_ros.fusion.config import FusionConfig, JointConfig
from mctrack_ros.fusion.explain.recorder import DecisionRecorder
from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.joint_tracker.pipeline import JointTracker
from mctrack_ros.fusion.trackers import (
    FUSION,
    FusionTracker,
    fusion_method,
    open_batcher,
    open_fusion,
    open_recorder,
)

__all__ = [
    'FUSION',
    'Batcher',
    'DecisionRecorder',
    'FusionConfig',
    'FusionOutput',
    'FusionTracker',
    'JointConfig',
    'JointTracker',
    'fusion_method',
    'open_batcher',
    'open_fusion',
    'open_recorder',
]
