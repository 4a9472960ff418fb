"""One camera: picture and feedback in, detections out."""

from mctrack_ros.perception.boxes import boxes_to_detections, positions_to_detections
from mctrack_ros.perception.feedback_buffer import FeedbackBuffer
from mctrack_ros.perception.local_events import feedback_missed
from mctrack_ros.perception.output import CameraOutput, check_picture
from mctrack_ros.perception.picture_clock import BackwardStampError
from mctrack_ros.perception.picture_state import PictureState, PictureWatch
from mctrack_ros.perception.pipeline import CameraConfig, CameraPipeline
from mctrack_ros.perception.trackers import CameraTracker, open_camera
from mctrack_ros.perception.watchdog import CameraShift, ShiftState

__all__ = [
    'BackwardStampError',
    'CameraConfig',
    'CameraOutput',
    'CameraPipeline',
    'CameraShift',
    'CameraTracker',
    'FeedbackBuffer',
    'PictureState',
    'PictureWatch',
    'ShiftState',
    'boxes_to_detections',
    'check_picture',
    'feedback_missed',
    'open_camera',
    'positions_to_detections',
]
