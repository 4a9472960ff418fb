import numpy as np

from mctrack_ros.simulation import Scenario, Walk, staged, true_tracks

SCENARIO = Scenario(duration_s=4.0, cameras=1)
THERE_AND_STAY = Walk(11, ((1.0, 10.0, 30.0), (3.0, 14.0, 30.0)))
STANDING = Walk(0, ((0.0, 12.0, 40.0),))


def test_only_who_walks_is_on_the_pitch():
    world = staged(SCENARIO, [THERE_AND_STAY, STANDING])
    assert true_tracks(world, 50).track_id.tolist() == [1, 12]
    assert np.flatnonzero(world.feet_in_view.any(axis=(0, 1))).tolist() == [0, 11]


def test_people_are_where_they_are_told_to_be():
    world = staged(SCENARIO, [THERE_AND_STAY, STANDING])
    walker = world.motion.position[:, 11]
    np.testing.assert_allclose(walker[[0, 49, 99]], [[10, 30], [12, 30], [14, 30]], atol=0.05)
    np.testing.assert_allclose(world.motion.velocity[50, 11], [2.0, 0.0], atol=0.05)
    assert np.ptp(world.motion.position[:, 0], axis=0).max() == 0.0


def test_who_stops_goes_on_facing_where_he_walked():
    heading = staged(SCENARIO, [THERE_AND_STAY]).motion.heading[:, 11]
    np.testing.assert_allclose(heading[30:], 0.0, atol=1e-6)
