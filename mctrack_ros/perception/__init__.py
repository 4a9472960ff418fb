"""One camera: picture and feedback in, detections out."""

from mctrack_ros.perception.feedback_buffer import FeedbackBuffer
from mctrack_ros.perception.local_events import feedback_missed
from mctrack_ros.perception.pipeline import (
    BackwardStampError,
    CameraConfig,
    CameraOutput,
    CameraPipeline,
)
from mctrack_ros.perception.watchdog import CameraShift, ShiftState

__all__ = [
    'BackwardStampError',
    'CameraConfig',
    'CameraOutput',
    'CameraPipeline',
    'CameraShift',
    'FeedbackBuffer',
    'ShiftState',
    'feedback_missed',
]
