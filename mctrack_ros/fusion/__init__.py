"""All cameras: ticks of detections -> tracks, feedback and events."""

from mctrack_ros.fusion.account import Account
from mctrack_ros.fusion.batcher import Batcher
from mctrack_ros.fusion.output import FusionOutput
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.pipeline import FusionPipeline

__all__ = ['Account', 'Batcher', 'FusionConfig', 'FusionOutput', 'FusionPipeline']
