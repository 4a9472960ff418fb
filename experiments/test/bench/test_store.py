"""The benchmark of the trajectory database measures what it says."""

from pathlib import Path

from mctrack_experiments.bench.store import RATE_HZ, TRACKS, bench_store
from mctrack_experiments.postgres_server import missing

BAG = Path(__file__).resolve().parents[3] / 'bags' / 'pitch5_detections'


def test_two_minutes_are_stored_small_and_found():
    figures = bench_store(BAG, minutes=2)
    assert figures.protocol['positions'] == TRACKS * RATE_HZ * 120
    for name in ['sqlite', *([] if missing() else ['postgres'])]:
        assert 10 < figures.figures[f'{name}.bytes_per_position'] < 60
        assert figures.figures[f'{name}.positions_per_s'] > 0
        assert figures.figures[f'{name}.query_ms'] > 0
