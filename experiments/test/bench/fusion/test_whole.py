import numpy as np

from mctrack_experiments.bench.fusion.synthetic_cameras import SyntheticCameras
from mctrack_experiments.bench.fusion.whole import STAGES, WholeTracker
from mctrack_ros.interfaces import Feedback

NOTHING = Feedback.build(0)


def test_cameras_keep_their_own_ids_and_learn_global_ones_by_feedback_alone(toolkit):
    scene = toolkit.scene(10, 1, cameras=1, clutter=0.0, detection_probability=1.0)
    cameras = SyntheticCameras(scene, 1)
    first, second = (cameras.messages(frame, NOTHING)[0].rows for frame in range(2))
    single = first.member_count == 1
    assert not first.track_id.any()
    assert len(set(first.local_id[single].tolist())) == single.sum()
    assert set(second.local_id.tolist()) == set(first.local_id.tolist())
    told = Feedback.build(1, position=first.position[:1], track_id=[7])
    third = cameras.messages(2, told)[0].rows
    assert (third.track_id == 7).sum() >= 1


def test_merged_detections_are_groups_of_those_known_to_be_there(toolkit):
    scene = toolkit.scene(25, 1, density=16.0)
    cameras, everybody = SyntheticCameras(scene, 1), scene.scenario.truth[0]
    told = Feedback.build(
        1, position=np.pad(everybody, ((0, 0), (0, 1))), track_id=1 + np.arange(len(everybody))
    )
    groups = [each.rows.select(each.rows.member_count == 2) for each in cameras.messages(0, told)]
    assert sum(map(len, groups)) > 0
    assert any(group.members[:, :2].all(axis=1).any() for group in groups)
    assert not any(group.track_id.any() for group in groups)


def test_a_whole_tick_tracks_and_times_every_stage(toolkit, scene):
    tracker = WholeTracker(scene)
    measured = toolkit.measure({'whole': tracker}, 50)['whole']
    assert toolkit.score(scene, measured.reported).mota > 0.9
    assert {stage: len(spent) for stage, spent in tracker.milliseconds.items()} == dict.fromkeys(
        STAGES, 50
    )
