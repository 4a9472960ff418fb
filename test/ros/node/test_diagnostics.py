"""What the diagnostics count."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from mctrack_ros.fusion import FusionOutput, Gates
from mctrack_ros.interfaces import Events, Tracks
from mctrack_ros.ros.health import stream_health
from mctrack_ros.ros.health.recording_health import Recorded, RecordingHealth
from mctrack_ros.ros.health.schedule_health import ScheduleHealth
from mctrack_ros.ros.health.stream_health import (
    DiagnosticsConfig,
    LatencyLevels,
    LossLevels,
    RateLevels,
    StreamHealth,
)
from mctrack_ros.ros.health.tracking_health import TrackingHealth

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


class Stream:
    """A camera that is heard for seconds of which a clock of our own says when they are over."""

    def __init__(self, monkeypatch, levels=None):
        self.now_s, self.index = 100.0, 0
        monkeypatch.setattr(stream_health.time, 'monotonic', lambda: self.now_s)
        self.health = StreamHealth(lambda: levels or DiagnosticsConfig())

    def second(self, rate, age_s=0.0):
        """Let a second pass with messages at a rate; return level, message and values."""
        for step in range(rate):
            stamp_ns = round((self.now_s + step / rate) * 1e9)
            self.health.arrived(stamp_ns, stamp_ns + round(age_s * 1e9))
        self.now_s += 1.0
        self.health._heard_s = self.now_s
        report = self.health.report('camera')
        return report.level, report.message, {one.key: one.value for one in report.values}


@pytest.mark.parametrize(
    ('late', 'level'),
    [(2, DiagnosticStatus.OK), (3, DiagnosticStatus.WARN), (5, DiagnosticStatus.ERROR)],
)
def test_how_many_messages_may_go_wrong_is_set_by_a_share(late, level):
    levels = DiagnosticsConfig(losses=LossLevels(warning=0.2, error=0.5))
    health = StreamHealth(levels=lambda: levels)
    for index in range(10):
        health.arrived(index * PERIOD_NS, index * PERIOD_NS)
    health.count('late', late)
    assert health.report('camera').level == level


@pytest.mark.parametrize('kind', ['feedback missed', 'dropped detections'])
def test_what_is_not_wrong_with_messages_themselves_is_a_warning_however_often(kind):
    health = StreamHealth(levels=lambda: DiagnosticsConfig(losses=LossLevels(warning=1.0)))
    for index in range(10):
        health.arrived(index * PERIOD_NS, index * PERIOD_NS)
    health.count(kind, 40)
    report = health.report('camera')
    assert (report.level, report.message) == (DiagnosticStatus.WARN, f'receiving; 40 {kind}')


def test_a_rate_that_falls_stays_a_warning_for_ever(monkeypatch):
    stream = Stream(monkeypatch)
    for _ in range(4):
        level, _, values = stream.second(25)
    assert (level, values['expected rate [Hz]']) == (DiagnosticStatus.OK, '25.0')
    for _ in range(20):
        level, message, values = stream.second(15)
    assert (level, message) == (DiagnosticStatus.WARN, 'receiving; 15.0 instead of 25.0 Hz')
    assert stream.second(10)[0] == DiagnosticStatus.ERROR
    assert stream.second(25)[0] == DiagnosticStatus.OK


def test_the_rate_that_is_stated_is_expected_from_the_first_message_on(monkeypatch):
    levels = DiagnosticsConfig(rate=RateLevels(warning=0.8, error=0.4, expected=30.0))
    stream = Stream(monkeypatch, levels)
    stream.second(25)
    assert stream.second(25)[0] == DiagnosticStatus.OK
    assert stream.second(20)[:2] == (
        DiagnosticStatus.WARN,
        'receiving; 20.0 instead of 30.0 Hz',
    )
    assert stream.second(10)[0] == DiagnosticStatus.ERROR


def test_old_messages_are_a_warning_and_then_an_error_by_their_levels(monkeypatch):
    levels = DiagnosticsConfig(latency=LatencyLevels(warning=0.1, error=0.5))
    stream = Stream(monkeypatch, levels)
    ages_s = (0.05, 0.2, 0.7)
    found = [stream.second(25, age_s) for age_s in ages_s]
    assert [level for level, *_ in found] == [
        DiagnosticStatus.OK,
        DiagnosticStatus.WARN,
        DiagnosticStatus.ERROR,
    ]
    assert found[2][1] == 'receiving; 0.70 s behind'
    assert found[1][2]['latency p99 [ms]'] == '200.0'


def test_tracking_says_how_late_it_is_and_what_its_gates_let_through():
    health = TrackingHealth(DiagnosticsConfig, ('cam1', 'cam2', 'cam3'))
    assert health.report('tracking').level == DiagnosticStatus.STALE
    tracks = Tracks.build(10**9, position=np.zeros((3, 3)), track_id=[1, 2, 3])
    gates = Gates(np.array([3, 5, 0]), np.array([0, 1, 0]), np.array([0, 2, 0]))
    output = FusionOutput(tracks, Events.build(10**9), gates=gates)
    for age_s, level in ((0.1, DiagnosticStatus.OK), (0.4, DiagnosticStatus.WARN)):
        for _ in range(2):
            health.published(output, round((1.0 + age_s) * 1e9))
        report = health.report('tracking')
        found = {one.key: one.value for one in report.values}
        assert report.level == level
        assert found['detections a tick'] == '8.0'
        assert found['assigned to tracks [%]'] == '62.5'
        assert (found['in no gate a tick'], found['taken by others a tick']) == ('1.0', '2.0')
        shares = [found[f'cam{number} assigned [%]'] for number in (1, 2, 3)]
        assert shares == ['100.0', '40.0', 'nan']
        assert found['publish latency p50 [ms]'] == f'{age_s * 1e3:.1f}'


def test_a_recording_warns_of_lost_messages_and_of_a_disk_that_is_nearly_full():
    now = Recorded(topics=2, messages=10, size=0, lost=0, left_out=0, room=10**9)
    health = RecordingHealth(lambda: now)
    assert health.report('recording').level == DiagnosticStatus.OK
    now = now._replace(messages=20, size=10**6, lost=3)
    report = health.report('recording')
    assert (report.level, report.message) == (
        DiagnosticStatus.WARN,
        'recording; 3 messages were lost',
    )
    now = now._replace(size=3 * 10**6, room=10**8)
    assert health.report('recording').message == 'recording; the disk will be full in 50 s'


def test_a_schedule_that_is_not_kept_is_a_warning_of_its_second():
    health = ScheduleHealth(lambda: 'playing')
    health.add(20_000_000)
    health.add(5_000_000)
    first = health.report('player')
    assert first.level == DiagnosticStatus.OK
    assert first.message == 'playing'
    assert {each.key: each.value for each in first.values} == {
        **{'rate [Hz]': '2.0', 'sent': '2', 'skipped': '0', 'worst delay [ms]': '20.0'}
    }
    health.add(250_000_000)
    health.skipped += 3
    second = health.report('player')
    assert second.level == DiagnosticStatus.WARN
    assert second.message == 'playing; 3 skipped; 250 ms late'
    assert health.report('player').level == DiagnosticStatus.OK
