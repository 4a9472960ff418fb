"""Synthetic scenes and cameras with exact truth."""

from mctrack_ros.simulation.cameras import Camera, pitch5_cameras
from mctrack_ros.simulation.carpark import CarParkScenario, CarParkWorld, GreyCarParkScenario
from mctrack_ros.simulation.difficulty import Difficulty, DifficultyMeter
from mctrack_ros.simulation.happenings import EventWatcher
from mctrack_ros.simulation.indoor import HallScenario, IndoorScenario
from mctrack_ros.simulation.pitch.field import LENGTH_M, WIDTH_M, landmarks, painted_lines
from mctrack_ros.simulation.pitch.ptz import PtzCamera, PtzScenario, ptz_cameras
from mctrack_ros.simulation.pitch.staging import Walk, placed, staged
from mctrack_ros.simulation.rendering.render import CameraRenderer
from mctrack_ros.simulation.rendering.sight import Sight, View
from mctrack_ros.simulation.scenario import Scenario
from mctrack_ros.simulation.scenes import (
    CARPARK,
    GREY_CARPARK,
    HALL,
    INDOOR,
    PITCH5,
    PTZ,
    SCENES,
    Figured,
    Renderer,
    Scene,
    scene_of,
)
from mctrack_ros.simulation.truth import (
    parked_detections,
    parked_tracks,
    true_detections,
    true_tracks,
)
from mctrack_ros.simulation.world import World

__all__ = [
    'CARPARK',
    'GREY_CARPARK',
    'HALL',
    'INDOOR',
    'LENGTH_M',
    'PITCH5',
    'PTZ',
    'SCENES',
    'WIDTH_M',
    'Camera',
    'CameraRenderer',
    'CarParkScenario',
    'CarParkWorld',
    'Difficulty',
    'DifficultyMeter',
    'EventWatcher',
    'Figured',
    'GreyCarParkScenario',
    'HallScenario',
    'IndoorScenario',
    'PtzCamera',
    'PtzScenario',
    'Renderer',
    'Scenario',
    'Scene',
    'Sight',
    'View',
    'Walk',
    'World',
    'landmarks',
    'painted_lines',
    'parked_detections',
    'parked_tracks',
    'pitch5_cameras',
    'placed',
    'ptz_cameras',
    'scene_of',
    'staged',
    'true_detections',
    'true_tracks',
]
