import numpy as np

from mctrack_ros.simulation import Scenario, Sight, World, true_detections, true_tracks

STEP = 4


def test_tracks_are_everybody_on_the_ground_by_id():
    world = World.simulated(Scenario(duration_s=0.4))
    tracks = true_tracks(world, STEP)
    assert tracks.stamp_ns == world.scenario.stamp_ns(STEP)
    assert tracks.track_id.tolist() == list(range(1, 26))
    assert np.bincount(tracks.kit).tolist() == [0, 11, 11, 3]
    np.testing.assert_allclose(tracks.position[:, :2], world.motion.position[STEP], atol=1e-5)


def test_detections_are_the_people_of_a_view_by_id():
    world = World.simulated(Scenario(duration_s=0.4))
    view = Sight(world, 2).view(STEP)
    rows = true_detections(world, STEP, view)
    assert rows.track_id.tolist() == sorted((view.person + 1).tolist())
    by_id = dict(zip((view.person + 1).tolist(), zip(view.visible, view.box.tolist())))
    for row, person in enumerate(rows.track_id.tolist()):
        visible, box = by_id[person]
        assert rows.score[row] == np.float32(visible)
        assert rows.box[row].tolist() == box
    places = world.motion.position[STEP, rows.track_id - 1]
    np.testing.assert_allclose(rows.position[:, :2], places, atol=1e-5)


def test_stamps_lie_in_the_middle_of_a_period():
    scenario = Scenario(start_ns=1_000)
    assert scenario.stamp_ns(0) == 1_000 + 20_000_000
    assert scenario.stamp_ns(3) == 1_000 + 140_000_000
