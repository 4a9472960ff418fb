"""Why a track is what it is: found in a bag, or by fusing its detections again."""

from mctrack_ros.explain.image import draw_explanation
from mctrack_ros.explain.numbers import write_story
from mctrack_ros.explain.story import Story, tell
from mctrack_ros.explain.words import COLUMNS, candidate_rows, course, sentences

__all__ = [
    'COLUMNS',
    'Story',
    'candidate_rows',
    'course',
    'draw_explanation',
    'sentences',
    'tell',
    'write_story',
]
