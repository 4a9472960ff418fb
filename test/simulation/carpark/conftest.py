import numpy as np
import pytest

from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation.carpark import CarParkScenario, carpark_cameras, staged
from mctrack_ros.simulation.carpark.activity.cast import Actor
from mctrack_ros.simulation.carpark.activity.paths import Course, standing

SIZE = {
    ClassCode.PERSON: np.array([0.4, 0.5, 1.75]),
    ClassCode.BICYCLE: np.array([1.74, 0.55, 1.72]),
    ClassCode.VEHICLE: np.array([4.2, 1.7, 1.45]),
}


@pytest.fixture
def scene():
    """Make a world of a few: (class, (2,) place or (steps, 2) places, heading) each."""

    def make(*given, steps=8, **options):
        actors = []
        for party, (kind, places, heading) in enumerate(given):
            path = np.asarray(places, float)
            still = standing(path, heading, steps) if path.ndim == 1 else None
            course = still or Course(path, np.full(len(path), float(heading)))
            actors.append(Actor(kind, party, 0, course, SIZE[kind]))
        scenario = CarParkScenario(duration_s=steps / 4, **options)
        return staged(scenario, actors, carpark_cameras(scenario))

    return make
