import numpy as np

from mctrack_ros.fusion.existence.view_overlap import TURNS, ViewOverlap

EVERYBODY = np.ones(1, bool)


def watch(views, seen, could, seconds):
    """Let one target be seen by some cameras for so long, and others that could see it not."""
    for _ in range(round(seconds / 0.04)):
        views.learn(np.array([seen]), np.array([could]), EVERYBODY, 0.04)


def test_nothing_is_known_at_first():
    np.testing.assert_array_equal(ViewOverlap(3).share(), np.ones((3, 3)))


def test_cameras_that_never_see_anybody_together_share_no_view():
    views = ViewOverlap(3)
    watch(views, [True, False, False], [False, True, True], 40.0)
    watch(views, [False, True, False], [True, False, False], 40.0)
    share = views.share()
    assert share[0, 1] < 0.06
    assert share[0, 2] < 0.06
    assert share[1, 0] < 0.06
    assert share[1, 2] == share[2, 0] == share[2, 1] == 1.0


def test_cameras_that_see_somebody_together_now_and_then_share_a_view():
    views = ViewOverlap(2)
    watch(views, [True, True], [False, False], 2.0)
    watch(views, [True, False], [False, True], 60.0)
    np.testing.assert_array_equal(views.share(), np.ones((2, 2)))


def test_hours_are_forgotten_evenly():
    views = ViewOverlap(2)
    for _ in range(30_000):
        views.learn(np.array([[True, True]]), np.zeros((1, 2), bool), EVERYBODY, 0.2)
    assert views.watched.max() <= 1001.0
    np.testing.assert_array_equal(views.together, views.watched)


def test_every_track_is_looked_at_as_long_as_it_is_there():
    views, count = ViewOverlap(2), 3 * TURNS + 1
    seen, could = np.tile([[True, False]], (count, 1)), np.tile([[False, True]], (count, 1))
    for _ in range(TURNS):
        views.learn(seen, could, np.ones(count, bool), 0.04)
    np.testing.assert_allclose(views.watched, [[0.0, count * TURNS * 0.04], [0.0, 0.0]])
