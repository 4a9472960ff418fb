"""All cameras: ticks of detections -> tracks, feedback and events."""

from mctrack_ros.fusion.batcher import Batcher
from mctrack_ros.fusion.config import FusionConfig
from mctrack_ros.fusion.explain.recorder import DecisionRecorder
from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.joint_tracker.pipeline import FusionPipeline

__all__ = ['Batcher', 'DecisionRecorder', 'FusionConfig', 'FusionOutput', 'FusionPipeline']
