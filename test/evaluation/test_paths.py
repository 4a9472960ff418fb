import numpy as np

from mctrack_ros.evaluation import Trajectories
from mctrack_ros.evaluation.paths import matched_paths
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
