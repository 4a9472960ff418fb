import numpy as np

from mctrack_experiments.same import digest, first_difference, recorded_rows
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagWriter

FIRST_NS = 1_700_000_000_040_000_000
PERIOD_NS = 40_000_000


def recorded(path, count=3, last_score=1.0):
    """Return the clouds of a bag with two tracks a message, the last with a score of its own."""
    with BagWriter(path) as writer:
        for index in range(count):
            scores = [1.0, last_score if index == count - 1 else 1.0]
            rows = Tracks.build(FIRST_NS + index * PERIOD_NS, track_id=[4, 7], score=scores)
            writer.write_rows('/tracks', rows, 'map')
        writer.write_text('/site', 'not rows', FIRST_NS)
    return recorded_rows(path)


def test_the_same_rows_are_the_same(tmp_path):
    one, other = recorded(tmp_path / 'one'), recorded(tmp_path / 'other')
    assert list(one) == ['/tracks']
    assert digest(one['/tracks']) == digest(other['/tracks'])
    assert first_difference(one['/tracks'], other['/tracks']) == ''


def test_the_first_row_and_value_that_differ_are_named(tmp_path):
    one = recorded(tmp_path / 'one')['/tracks']
    other = recorded(tmp_path / 'other', last_score=np.nextafter(np.float32(1), np.float32(0)))[
        '/tracks'
    ]
    assert digest(one) != digest(other)
    found = first_difference(one, other)
    assert found.startswith('message 2 at 1700000000.120 s: row 1, score [1.0], now [0.99999')


def test_a_missing_message_is_named(tmp_path):
    one = recorded(tmp_path / 'one')['/tracks']
    other = recorded(tmp_path / 'other', count=2)['/tracks']
    assert first_difference(one, other) == '3 messages, now 2'
    assert first_difference(one, []) == '3 messages, now 0'
