import numpy as np
import pytest

from mctrack_experiments.papers.event_tracking.fig14 import DURATION_S, play, walks
from mctrack_experiments.papers.event_tracking.paths import with_past
from mctrack_ros.interfaces import EventCode
from mctrack_ros.simulation import EventWatcher, Scenario, Sight, staged


@pytest.mark.parametrize('seed', [1, 2, 3])
def test_three_are_one_silhouette_at_first_and_split_twice(seed):
    scenario = Scenario(seed=seed, duration_s=DURATION_S, cameras=1)
    world = staged(scenario, walks(seed))
    watcher, sight = EventWatcher(world, 0), Sight(world, 0)
    told = [watcher.step(step, sight.view(step)).event for step in range(scenario.steps)]
    assert told[0].tolist().count(EventCode.MERGE) == 2
    assert np.concatenate(told[1:]).tolist().count(EventCode.SPLIT) == 2


def test_who_splits_off_shares_the_past_of_the_group(here):
    truth, tracks, origin = play(1)
    assert len(origin) >= 1
    begun = truth.frame.min()
    inherited = with_past(tracks, origin)
    for part in origin:
        assert tracks.frame[tracks.id == part].min() > begun + 10
        assert inherited.frame[inherited.id == part].min() <= begun
