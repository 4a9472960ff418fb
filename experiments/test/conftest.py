"""What the tests of experiments share: jobs done in this process, and tracked matches kept."""

import pytest

from here import Here, RenderingHere
from mctrack_experiments.bench import workers
from mctrack_experiments.papers.event_tracking.tracked_match import TrackedMatch
from mctrack_ros.simulation import recording


@pytest.fixture(scope='module')
def here():
    """Let recordings be rendered, and jobs be run, in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recording, 'ProcessPoolExecutor', RenderingHere)
        patch.setattr(workers, 'ProcessPoolExecutor', Here)
        yield


@pytest.fixture(scope='session')
def matches():
    """Return the tracked matches so far, by scenario."""
    return {}


@pytest.fixture
def kept_matches(here, matches, monkeypatch, tmp_path_factory):
    """Let experiments that track the same match share it."""
    made = TrackedMatch.made

    def once(world, folder):
        scenario = world.scenario
        if scenario not in matches:
            matches[scenario] = made(world, tmp_path_factory.mktemp('match'))
        return matches[scenario]

    monkeypatch.setattr(TrackedMatch, 'made', once)
