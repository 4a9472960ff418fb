from mctrack_experiments.bench.perception.belief import bench_belief


def test_the_bench_times_a_tick_without_and_with_images_and_people_are_followed():
    figures = bench_belief(14).figures
    assert figures['no_images.frames_per_second'] > 0
    assert figures['images.frames_per_second'] > 0
    assert figures['images.error_m'] < 0.3
