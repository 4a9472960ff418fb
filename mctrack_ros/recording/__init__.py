"""Bags and exports."""

from mctrack_ros.recording.bags.attached import PARAMETERS, attachments
from mctrack_ros.recording.bags.bag import BagReader
from mctrack_ros.recording.bags.files import is_bag
from mctrack_ros.recording.bags.site_topic import stated_clock_offsets, stated_origin
from mctrack_ros.recording.bags.writer import ROSBAGS_CLASSES, BagWriter, Storage, check_place
from mctrack_ros.recording.errors import BagError, CutBagWarning
from mctrack_ros.recording.tracks.mot_text import (
    MotTextError,
    MotTextWriter,
    mot_text_place,
    read_mot_text,
    write_mot_text,
)
from mctrack_ros.recording.tracks.track_table import TrackTableWriter
from mctrack_ros.recording.tracks.track_writer import frame_origin_ns

__all__ = [
    'PARAMETERS',
    'ROSBAGS_CLASSES',
    'BagError',
    'BagReader',
    'BagWriter',
    'CutBagWarning',
    'MotTextError',
    'MotTextWriter',
    'Storage',
    'TrackTableWriter',
    'attachments',
    'check_place',
    'frame_origin_ns',
    'is_bag',
    'mot_text_place',
    'read_mot_text',
    'stated_clock_offsets',
    'stated_origin',
    'write_mot_text',
]
