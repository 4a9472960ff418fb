import pytest

from mctrack_ros.simulation import DifficultyMeter, EventWatcher, Scenario, Sight, World

EVERY = 10


@pytest.mark.parametrize('seed', [1, 2])
def test_pitch5_is_never_easier_than_its_floors(seed):
    world = World.simulated(Scenario(seed=seed, duration_s=60.0))
    meter = DifficultyMeter(world)
    for index in range(len(world.cameras)):
        sight, watcher = Sight(world, index), EventWatcher(world, index)
        for step in range(0, world.scenario.steps, EVERY):
            view = sight.view(step)
            meter.add(view, watcher.step(step, view))
    difficulty = meter.result()
    assert difficulty.occluded_share >= 0.15
    assert difficulty.merges_per_camera_minute / EVERY >= 8
    assert difficulty.same_kit_close_share >= 0.05
    assert difficulty.seen_share > 0.999
    assert difficulty.occluded_share < 0.25
