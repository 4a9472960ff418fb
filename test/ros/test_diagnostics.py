"""What the diagnostics count."""

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
