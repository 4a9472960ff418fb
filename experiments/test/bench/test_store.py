"""The benchmark of the trajectory database measures what it says."""

from pathlib import Path

import pytest

from mctrack_experiments.bench import store
from mctrack_experiments.bench.store import RATE_HZ, TRACKS, bench_store, bench_store_long
from mctrack_experiments.postgres_server import missing

BAG = Path(__file__).resolve().parents[3] / 'bags' / 'pitch5_detections'


def test_two_minutes_are_stored_small_and_found():
    figures = bench_store(BAG, minutes=2)
    assert figures.protocol['positions'] == TRACKS * RATE_HZ * 120
    for name in ['sqlite', *([] if missing() else ['postgres'])]:
        assert 10 < figures.figures[f'{name}.bytes_per_position'] < 60
        assert figures.figures[f'{name}.positions_per_s'] > 0
        assert figures.figures[f'{name}.query_ms'] > 0


def test_a_month_is_drawn_on_from_what_is_measured(monkeypatch):
    monkeypatch.setattr(store, '_HOUR_TICKS', 60 * RATE_HZ)  # an hour of a minute
    monkeypatch.setattr(store, 'QUESTIONS', 5)
    figures = bench_store_long(BAG, hours=4).figures
    assert figures['positions'] == 4 * TRACKS * RATE_HZ * 60
    assert figures['last.gigabytes'] > figures['first.gigabytes'] > 0
    grown = (figures['last.gigabytes'] - figures['first.gigabytes']) / 3
    assert figures['month.gigabytes'] == pytest.approx(720 * grown, rel=0.1)
