"""Frozen arrays for one instant, the words that all parts of the graph share."""

from mctrack_ros.interfaces.belief import Belief
from mctrack_ros.interfaces.codes import (
    MAX_CAMERAS,
    MEMBERS,
    REPORTED,
    TEMPLATE_SIZE,
    ZONE_EVENTS,
    Choice,
    ClassCode,
    EventCode,
    Reason,
    TrackStatus,
    code_tables,
)
from mctrack_ros.interfaces.detections import Detections
from mctrack_ros.interfaces.events import NO_CAMERA, Events
from mctrack_ros.interfaces.explanation import Candidates, Decisions, Explanation
from mctrack_ros.interfaces.feedback import Feedback
from mctrack_ros.interfaces.foreground import Foreground
from mctrack_ros.interfaces.likelihood import NO_EDGE, Likelihood
from mctrack_ros.interfaces.limits import (
    LARGEST_DISTANCE,
    LARGEST_EXTENT,
    LARGEST_SPEED,
    LARGEST_VARIANCE,
    PAUSE_NS,
    RESTART_NS,
    starts_anew,
)
from mctrack_ros.interfaces.rows import Column, Message, Rows, Stamped
from mctrack_ros.interfaces.ticks import CameraDetections, CameraRows, RowsTick, Tick, Ticks
from mctrack_ros.interfaces.tracks import Tracks

__all__ = [
    'LARGEST_DISTANCE',
    'LARGEST_EXTENT',
    'LARGEST_SPEED',
    'LARGEST_VARIANCE',
    'MAX_CAMERAS',
    'MEMBERS',
    'NO_CAMERA',
    'NO_EDGE',
    'PAUSE_NS',
    'REPORTED',
    'RESTART_NS',
    'TEMPLATE_SIZE',
    'ZONE_EVENTS',
    'Belief',
    'CameraDetections',
    'CameraRows',
    'Candidates',
    'Choice',
    'ClassCode',
    'Column',
    'Decisions',
    'Detections',
    'EventCode',
    'Events',
    'Explanation',
    'Feedback',
    'Foreground',
    'Likelihood',
    'Message',
    'Reason',
    'Rows',
    'RowsTick',
    'Stamped',
    'Tick',
    'Ticks',
    'TrackStatus',
    'Tracks',
    'code_tables',
    'starts_anew',
]
