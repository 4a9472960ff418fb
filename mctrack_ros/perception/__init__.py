"""One camera: image and feedback in, detections out."""

from mctrack_ros.perception.boxes import boxes_to_detections, positions_to_detections
from mctrack_ros.perception.camera_shift.monitor import CameraShift, ShiftState
from mctrack_ros.perception.config import CameraConfig
from mctrack_ros.perception.event_tracker.config import EventTrackerConfig
from mctrack_ros.perception.event_tracker.pipeline import EventTracker
from mctrack_ros.perception.events.event_log import feedback_missed
from mctrack_ros.perception.feedback.buffer import FeedbackBuffer, RowsBuffer
from mctrack_ros.perception.image_clock import BackwardStampError
from mctrack_ros.perception.image_state import ImageState, ImageWatch
from mctrack_ros.perception.output import CameraOutput, check_image
from mctrack_ros.perception.trackers import (
    CAMERA,
    CameraTracker,
    Given,
    camera_method,
    open_buffer,
    open_camera,
)

__all__ = [
    'CAMERA',
    'BackwardStampError',
    'CameraConfig',
    'CameraOutput',
    'CameraShift',
    'CameraTracker',
    'EventTracker',
    'EventTrackerConfig',
    'FeedbackBuffer',
    'Given',
    'ImageState',
    'ImageWatch',
    'RowsBuffer',
    'ShiftState',
    'boxes_to_detections',
    'camera_method',
    'check_image',
    'feedback_missed',
    'open_buffer',
    'open_camera',
    'positions_to_detections',
]
