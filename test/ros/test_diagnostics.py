"""What the diagnostics count."""

from diagnostic_msgs.msg import DiagnosticStatus

from mctrack_ros.ros.diagnostics import StreamHealth

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
    for index in (100, 101, 101, 100, 102):
        health.arrived(index * PERIOD_NS, index * PERIOD_NS)
    assert health.totals.get('lost', 0) <= 1


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
