import pytest

from mctrack_experiments.papers.event_tracking.fig16 import CASES, DURATION_S, SETTLED_S, play
from mctrack_ros.interfaces import EventCode
from mctrack_ros.simulation import EventWatcher, Scenario, Sight, staged

TRUE_COUNTS = {
    'grouping': {EventCode.MERGE: 1, EventCode.SPLIT: 1},
    'splitting': {EventCode.SPLIT: 2},
    'entering': {EventCode.ENTER: 1},
    'leaving': {EventCode.EXIT: 1},
}


@pytest.mark.parametrize('seed', [1, 2])
@pytest.mark.parametrize('case', CASES, ids=lambda case: case.name)
def test_what_a_case_is_called_truly_happens(case, seed):
    scenario = Scenario(seed=seed, duration_s=DURATION_S, cameras=2)
    world = staged(scenario, case.walks(seed))
    index = [camera.name for camera in world.cameras].index(case.camera)
    watcher, sight = EventWatcher(world, index), Sight(world, index)
    codes = [
        code
        for step in range(scenario.steps)
        for code in watcher.step(step, sight.view(step)).event.tolist()
        if step * scenario.period_s > SETTLED_S
    ]
    assert {code: codes.count(code) for code in case.codes} == TRUE_COUNTS[case.name]


def test_who_leaves_an_image_is_told_and_keeps_the_id(here):
    leaving = next(case for case in CASES if case.name == 'leaving')
    score, switched, people = play(leaving, 1)
    assert (score.true, score.told, score.hits) == (1, 1, 1)
    assert (switched, people) == (0, 2)
