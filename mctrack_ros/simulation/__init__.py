"""Synthetic scenes and cameras with exact truth."""

from mctrack_ros.simulation.cameras import Camera, pitch5_cameras
from mctrack_ros.simulation.difficulty import Difficulty, DifficultyMeter
from mctrack_ros.simulation.happenings import EventWatcher
from mctrack_ros.simulation.pitch import LENGTH_M, WIDTH_M, landmarks
from mctrack_ros.simulation.render import CameraRenderer
from mctrack_ros.simulation.scenario import Scenario
from mctrack_ros.simulation.sight import Sight, View
from mctrack_ros.simulation.truth import true_detections, true_tracks
from mctrack_ros.simulation.world import World

__all__ = [
    'LENGTH_M',
    'WIDTH_M',
    'Camera',
    'CameraRenderer',
    'Difficulty',
    'DifficultyMeter',
    'EventWatcher',
    'Scenario',
    'Sight',
    'View',
    'World',
    'landmarks',
    'pitch5_cameras',
    'true_detections',
    'true_tracks',
]
