"""What the diagnostics count."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from mctrack_ros.ros.health.stream_health import StreamHealth

PERIOD_NS = 40_000_000


def values(health):
    return {value.key: value.value for value in health.report('camera').values}


def test_rate_and_latency_are_those_since_the_last_report():
    health = StreamHealth()
    for index in range(3):
        health.arrived(index * PERIOD_NS, index * PERIOD_NS + 10_000_000 * (index + 1))
    reported = values(health)
    assert reported['rate [Hz]'] == '3.0'
    assert reported['mean latency [ms]'] == '20.0'
    assert reported['worst latency [ms]'] == '30.0'
    assert health.report('camera').message == 'no data'


def test_gaps_are_lost_messages():
    health = StreamHealth()
    for index in (100, 101, 102, 105, 106):
        health.arrived(index * PERIOD_NS, index * PERIOD_NS)
    assert health.totals == {'lost': 2}


def test_late_messages_are_not_lost_ones():
    health = StreamHealth()
    for index in (100, 101, 101, 100, 102, 103, 103, 104):
        health.arrived(index * PERIOD_NS, index * PERIOD_NS)
    assert health.totals == {}


def lost_by(stamps_s):
    """Return how many messages were lost by each second of a stream, given stamps, s."""
    health, lost = StreamHealth(), {}
    for stamp_s in stamps_s:
        stamp_ns = 1_700_000_000 * 10**9 + round(stamp_s * 1e9)
        health.arrived(stamp_ns, stamp_ns)
        lost[int(stamp_s)] = health.totals.get('lost', 0)
    return list(lost.values())


def test_images_that_come_early_now_and_then_show_nothing_to_be_lost():
    stamps = np.arange(600) * 0.1
    stamps[5::20] -= 0.04
    assert lost_by(stamps)[-1] == 0


@pytest.mark.parametrize('rate', [1.0, 10.0, 25.0, 120.0])
@pytest.mark.parametrize('seed', range(3))
def test_jitter_shows_nothing_to_be_lost_and_what_is_lost_is_counted(rate, seed):
    rng = np.random.default_rng(seed)
    stamps = (np.arange(1000) + rng.normal(0, 0.05, 1000)) / rate
    assert lost_by(stamps)[-1] == 0
    kept = rng.random(1000) > 0.1
    kept[:5] = kept[-1] = True
    assert lost_by(stamps[kept])[-1] == (~kept).sum()


def test_a_long_gap_counts_what_it_would_have_held_but_a_pause_does_not():
    before = np.arange(20) * 0.1
    assert lost_by([*before, *(before + 5.0)])[-1] == 30
    assert lost_by([*before, *(before + 60.0)])[-1] == 0


@pytest.mark.parametrize(('first', 'then'), [(25.0, 12.5), (12.5, 25.0), (30.0, 7.5)])
def test_a_rate_that_changes_does_not_go_on_to_count_as_lost(first, then):
    stamps = [*np.arange(0.0, 10.0, 1 / first), *np.arange(10.0, 30.0, 1 / then)]
    lost = lost_by(stamps)
    assert lost[9] == 0
    assert lost[-1] == lost[13]
    assert lost[-1] <= 13 * round(max(first / then - 1, 0))


def test_a_rate_that_drifts_from_25_to_12_and_back_shows_nothing_to_be_lost():
    interval = 0.06 - 0.02 * np.cos(np.linspace(0, 2 * np.pi, 800))
    assert lost_by(np.cumsum(interval))[-1] == 0


@pytest.mark.parametrize('seed', range(3))
def test_messages_at_no_rate_are_called_irregular_and_none_of_them_lost(seed):
    health = StreamHealth()
    for stamp_s in np.cumsum(np.random.default_rng(seed).uniform(0.04, 0.3, 500)):
        health.arrived(round(stamp_s * 1e9), 0)
    assert values(health)['interval [ms]'] == 'irregular'
    assert health.totals.get('lost', 0) <= 5


def test_stamps_that_step_back_begin_anew_at_the_same_rate():
    health = StreamHealth()
    for index in [*range(1000, 1050), *range(100, 150), *range(153, 200)]:
        health.arrived(index * PERIOD_NS, 0)
    assert health.totals == {'lost': 3}
    assert values(health)['interval [ms]'] == '40.0'


def test_what_went_wrong_in_the_last_second_is_a_warning_and_nothing_usable_an_error():
    health = StreamHealth()

    def second(refused=0, first=0):
        for index in range(first, first + 3):
            health.arrived(index * PERIOD_NS, index * PERIOD_NS)
        for _ in range(refused):
            health.count('refused')
        reported = health.report('camera')
        return reported.level, reported.message

    assert second() == (DiagnosticStatus.OK, 'receiving')
    assert second(1, 3) == (DiagnosticStatus.WARN, 'receiving; 1 refused')
    assert second(3, 6) == (DiagnosticStatus.ERROR, 'receiving; 3 refused')
    assert second(0, 9) == (DiagnosticStatus.OK, 'receiving')
    assert second(0, 15) == (DiagnosticStatus.WARN, 'receiving; 3 lost')
    assert health.report('camera').level == DiagnosticStatus.STALE
