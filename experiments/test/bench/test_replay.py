"""The benchmark of replays measures what it says."""

from pathlib import Path

from mctrack_experiments.bench.replay import bench_replay

BAG = Path(__file__).resolve().parents[3] / 'bags' / 'pitch5_detections'


def test_orders_of_arrival_and_processes_give_one_hash_and_changed_bits_are_found():
    figures = bench_replay(BAG, replays=3, flips=2, picture_s=0.0).figures
    assert figures['hashes'] == 1
    assert figures['flips.found'] == 2
    assert figures['detections.realtime_factor'] > 0
