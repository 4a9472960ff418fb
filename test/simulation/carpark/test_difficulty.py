from mctrack_ros.interfaces import ClassCode
from mctrack_ros.simulation import EventWatcher
from mctrack_ros.simulation.carpark import (
    CarParkMeter,
    CarParkRenderer,
    CarParkScenario,
    carpark_world,
)


def test_the_car_park_is_never_easier_than_its_floors():
    world = carpark_world(CarParkScenario(seed=1, duration_s=80))
    meter, watcher = CarParkMeter(world), EventWatcher(world, 0)
    renderer = CarParkRenderer(world, 0)
    for step in range(world.scenario.steps):
        _, view = renderer.frame(step)
        meter.add(view, watcher.step(step, view))
    difficulty = meter.result()
    assert difficulty.contrast < 35
    assert difficulty.fragmented_people >= 27 / 152
    assert difficulty.fragmented_share >= 0.05
    assert difficulty.merges_per_camera_minute >= 4


def test_bicycles_are_counted_apart_from_cars(scene):
    kinds = (ClassCode.BICYCLE, ClassCode.VEHICLE, ClassCode.BICYCLE, ClassCode.PERSON)
    world = scene(*[(kind, (4.0 * place, 8.0), 0.0) for place, kind in enumerate(kinds)])
    assert CarParkMeter(world).result().figures()['bicycles'] == 2
