import pytest

from mctrack_experiments.papers.event_tracking.pairs import KITS, MEETINGS, walks
from mctrack_ros.simulation import EventWatcher, Scenario, Sight, staged


@pytest.mark.parametrize('kits', KITS)
def test_nearly_all_pairs_truly_merge_and_split(kits):
    scenario = Scenario(seed=1, duration_s=10.0, rate_hz=10.0, cameras=5)
    world = staged(scenario, walks(kits, 1))
    met = set()
    for index in range(len(world.cameras)):
        watcher, sight = EventWatcher(world, index), Sight(world, index)
        for step in range(scenario.steps):
            events = watcher.step(step, sight.view(step))
            for row in range(len(events)):
                others = events.others[row][events.others[row] > 0].tolist()
                met.add((int(events.event[row]), frozenset([events.track_id[row], *others])))
    pairs = [frozenset(person + 1 for person in pair) for pair in KITS[kits]]
    assert sum((3, pair) in met and (5, pair) in met for pair in pairs) >= 2 * len(MEETINGS) - 1


def test_a_seed_gives_the_same_walks():
    assert walks('same', 3) == walks('same', 3) != walks('same', 4)
