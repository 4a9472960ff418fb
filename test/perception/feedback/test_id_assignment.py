import numpy as np
import pytest

from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception.feedback.id_assignment import learn_identities
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.local_tracks.table import FilterConfig, LocalTracks

NOW = 1_000_000_000
DELAY = 80_000_000


@pytest.fixture
def tracks_at(mapping):
    def make(*places):
        sizes = SizeTable(mapping)
        tracks = LocalTracks(FilterConfig(), mapping, sizes)
        foot = mapping.image_from_ground(places)
        box = sizes.box_of(foot, np.tile([0.6, 1.75], (len(foot), 1)))
        noise = tracks.foot_noise(box)
        tracks.start(np.asarray(places, float), box, noise, np.zeros((len(foot), 48)), 0)
        tracks.confirmed[:] = True
        return tracks

    return make


def reported(*targets, variance=0.05):
    """Return feedback of (id, x, y) or (id, x, y, previous id)."""
    count = len(targets)
    return Feedback.build(
        NOW - DELAY,
        position=[(*target[1:3], 0.0) for target in targets],
        covariance=np.tile(np.eye(4) * variance, (count, 1, 1)),
        track_id=[target[0] for target in targets],
        previous_id=[target[3] if len(target) > 3 else 0 for target in targets],
    )


def learn(tracks, feedback):
    learn_identities(tracks, feedback, NOW)
    return tracks.track_id.tolist()


def test_each_track_takes_the_id_of_its_target(tracks_at):
    tracks = tracks_at((0.0, 0.0), (2.0, 0.0))
    assert learn(tracks, reported((8, 2.1, 0.0), (5, 0.1, 0.0), (9, -6.0, 0.0))) == [5, 8]


def test_one_target_gives_its_id_to_one_track(tracks_at):
    assert sorted(learn(tracks_at((0.0, 0.0), (0.2, 0.0)), reported((5, 0.0, 0.0)))) == [0, 5]


@pytest.mark.parametrize(('away', 'expected'), [(1.45, 5), (1.55, 0)])
def test_no_id_is_learned_from_a_target_that_is_far_however_uncertain_it_is(
    tracks_at, away, expected
):
    assert learn(tracks_at((0.0, 0.0)), reported((5, away, 0.0), variance=4.0)) == [expected]


def test_id_is_kept_while_another_target_is_nearer(tracks_at):
    tracks = tracks_at((0.0, 0.0))
    learn(tracks, reported((5, 0.0, 0.0)))
    assert learn(tracks, reported((5, 1.0, 0.0), (6, 0.0, 0.0))) == [5]


def test_id_of_a_target_that_is_gone_or_far_is_given_up(tracks_at):
    tracks = tracks_at((0.0, 0.0))
    learn(tracks, reported((5, 0.0, 0.0)))
    assert learn(tracks, reported((5, 6.0, 0.0))) == [0]


def test_corrections_rename_all_at_once(tracks_at):
    tracks = tracks_at((0.0, 0.0), (2.0, 0.0))
    learn(tracks, reported((5, 0.0, 0.0), (8, 2.0, 0.0)))
    assert learn(tracks, reported((8, 0.0, 0.0, 5), (5, 2.0, 0.0, 8))) == [8, 5]


def test_tentative_tracks_learn_nothing(tracks_at):
    tracks = tracks_at((0.0, 0.0))
    tracks.confirmed[:] = False
    assert learn(tracks, reported((5, 0.0, 0.0))) == [0]
