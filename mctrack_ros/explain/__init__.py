"""Why a track is what it is: found in a bag, or by fusing its detections again."""

from mctrack_ros.explain.history import TrackHistory, history_of
from mctrack_ros.explain.image import draw_explanation
from mctrack_ros.explain.numbers import write_history
from mctrack_ros.explain.words import COLUMNS, candidate_rows, course, sentences

__all__ = [
    'COLUMNS',
    'TrackHistory',
    'candidate_rows',
    'course',
    'draw_explanation',
    'history_of',
    'sentences',
    'write_history',
]
