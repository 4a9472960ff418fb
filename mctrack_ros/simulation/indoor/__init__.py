"""The indoor scene of the likelihood-grid paper: a room, four ceiling cameras, people close by."""

from mctrack_ros.simulation.indoor.difficulty import IndoorMeter
from mctrack_ros.simulation.indoor.people import indoor_world
from mctrack_ros.simulation.indoor.render import IndoorRenderer
from mctrack_ros.simulation.indoor.scenario import IndoorScenario

__all__ = ['IndoorMeter', 'IndoorRenderer', 'IndoorScenario', 'indoor_world']
