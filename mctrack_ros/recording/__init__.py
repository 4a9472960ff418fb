"""Bags and exports."""

from mctrack_ros.recording.bag import ROSBAGS_CLASSES, BagError, BagReader, BagWriter

__all__ = ['ROSBAGS_CLASSES', 'BagError', 'BagReader', 'BagWriter']
