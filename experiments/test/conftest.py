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
    """Return the tracked matches so far, by scenario and how backgrounds are learned."""
    return {}


@pytest.fixture
def kept_matches(here, matches, monkeypatch, tmp_path_factory):
    """Let experiments that track the same match share it."""
    made = TrackedMatch.made

    def once(world, folder, is_given=True, first_pass=True):
        key = world.scenario, is_given, first_pass
        if key not in matches:
            matches[key] = made(world, tmp_path_factory.mktemp('match'), is_given, first_pass)
        return matches[key]

    monkeypatch.setattr(TrackedMatch, 'made', once)
