"""A car park in grey, after the silhouettes paper's conditions."""

from mctrack_ros.simulation.carpark.difficulty import CarParkDifficulty, CarParkMeter
from mctrack_ros.simulation.carpark.grey import (
    GreyCarParkScenario,
    grey_carpark_cameras,
    grey_carpark_world,
)
from mctrack_ros.simulation.carpark.layout import carpark_cameras
from mctrack_ros.simulation.carpark.rendering.render import CarParkRenderer, CarParkView
from mctrack_ros.simulation.carpark.scenario import CarParkScenario
from mctrack_ros.simulation.carpark.world import CarParkWorld, carpark_world, staged

__all__ = [
    'CarParkDifficulty',
    'CarParkMeter',
    'CarParkRenderer',
    'CarParkScenario',
    'CarParkView',
    'CarParkWorld',
    'GreyCarParkScenario',
    'carpark_cameras',
    'carpark_world',
    'grey_carpark_cameras',
    'grey_carpark_world',
    'staged',
]
