"""Rooms with people close by: that of the likelihood-grid paper, and a hall with one door."""

from mctrack_ros.simulation.indoor.difficulty import IndoorMeter
from mctrack_ros.simulation.indoor.hall import (
    HallRenderer,
    HallScenario,
    hall_cameras,
    hall_landmarks,
    hall_world,
)
from mctrack_ros.simulation.indoor.people import indoor_world
from mctrack_ros.simulation.indoor.render import IndoorRenderer
from mctrack_ros.simulation.indoor.scenario import IndoorScenario

__all__ = [
    'HallRenderer',
    'HallScenario',
    'IndoorMeter',
    'IndoorRenderer',
    'IndoorScenario',
    'hall_cameras',
    'hall_landmarks',
    'hall_world',
    'indoor_world',
]
