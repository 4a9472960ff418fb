import numpy as np

from mctrack_experiments.papers.event_tracking.paths import matched_paths, with_past
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.interfaces import Tracks, TrackStatus


def rows(places, ids):
    """Return trajectories of (frames, n, 2) places."""
    instants = [
        Tracks.build(
            frame * 10,
            position=np.column_stack([place, np.zeros(len(place))]),
            track_id=ids,
            status=np.full(len(place), TrackStatus.CONFIRMED),
        )
        for frame, place in enumerate(np.asarray(places, float))
    ]
    return Trajectories.from_tracks(instants, 10, 0)


def test_paths_hold_both_places_where_a_track_is_near():
    steps = np.arange(4.0)
    true = np.stack([np.stack([steps, 2 * steps], 1), np.stack([steps + 50, -steps], 1)], 1)
    found = true + np.array([0.3, 0.4])
    found[2, 1] += 9.0
    paths = matched_paths(rows(true, [7, 9]), rows(found, [1, 2]), 1.0)
    assert sorted(paths) == [7, 9]
    assert paths[9].frame.tolist() == [0, 1, 3]
    np.testing.assert_allclose(paths[7].true, true[:, 0])
    np.testing.assert_allclose(paths[7].rmse_m(), [0.3, 0.4], rtol=1e-5)
    np.testing.assert_allclose(paths[7].correlation(), 1.0)


def test_who_is_never_tracked_has_no_path():
    assert matched_paths(rows([[[0, 0]]], [3]), rows([[[5, 0]]], [1]), 1.0) == {}


def test_who_splits_from_a_group_has_its_past_and_that_of_its_own_origin():
    tracks = Trajectories(
        frame=[0, 1, 2, 3, 2, 3, 3],
        id=[1, 1, 1, 1, 2, 2, 3],
        position=np.arange(14.0).reshape(7, 2),
    )
    whole = with_past(tracks, {3: 2, 2: 1, 1: 1})
    paths = {
        track: dict(zip(whole.frame[whole.id == track], whole.position[whole.id == track, 0]))
        for track in (1, 2, 3)
    }
    assert paths[1] == {0: 0, 1: 2, 2: 4, 3: 6}
    assert paths[2] == {0: 0, 1: 2, 2: 8, 3: 10}
    assert paths[3] == {0: 0, 1: 2, 2: 8, 3: 12}
    assert len(with_past(tracks, {2: 3, 3: 2})) == len(tracks) + 1
