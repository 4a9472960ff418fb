"""Bags and exports."""

from mctrack_ros.recording.bag import (
    ROSBAGS_CLASSES,
    BagError,
    BagReader,
    BagWriter,
    check_place,
)
from mctrack_ros.recording.mot_text import (
    MotTextError,
    MotTextWriter,
    frame_origin_ns,
    read_mot_text,
    write_mot_text,
)
from mctrack_ros.recording.track_table import TrackTableWriter

__all__ = [
    'ROSBAGS_CLASSES',
    'BagError',
    'BagReader',
    'BagWriter',
    'MotTextError',
    'MotTextWriter',
    'TrackTableWriter',
    'check_place',
    'frame_origin_ns',
    'read_mot_text',
    'write_mot_text',
]
