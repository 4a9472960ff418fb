from mctrack_ros.experiments.bench_camera import bench_camera


def test_the_bench_times_the_silhouettes_tracker_and_its_stages():
    figures = bench_camera(12).figures
    assert figures['silhouettes.fps'] > 0
    assert figures['silhouettes.background_ms'] > 0
    assert figures['peer.mog2_components.fps'] > 0
