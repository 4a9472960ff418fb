from mctrack_experiments.bench.perception.camera import bench_camera
from mctrack_experiments.bench.perception.pitch import crowd

STAGES = ('decoding', 'camera_shift', 'background', 'cleaning', 'blobs')


def test_the_bench_times_both_trackers_their_stages_and_peers():
    figures = bench_camera(6).figures
    assert figures['silhouettes.fps'] > 0
    assert figures['silhouettes.background_ms'] > 0
    assert figures['peer.mog2_components.fps'] > 0
    assert figures['decoded.fps'] > figures['jpeg.fps'] > 0
    assert all(figures[f'decoded.{stage}_ms'] > 0 for stage in STAGES)
    assert figures['peer.mog2_contours.fps'] > 0
    assert figures['crowded.persons'] > figures['crowded50.persons'] > figures['decoded.persons']


def test_a_crowd_is_several_matches_at_once():
    world = crowd(2, 3, 1)
    assert world.motion.position.shape == (3, 50, 2)
    assert len(world.ids) == len(world.extent) == 50
    assert world.feet_in_view.shape == (3, 5, 50)
