import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mctrack_ros.interfaces import Tracks, TrackStatus
from mctrack_ros.recording import MotTextError, read_mot_text, write_mot_text

PERIOD_NS = 40_000_000


def ticks(phase_ns=PERIOD_NS // 2):
    start = 5_000_000_000 + phase_ns
    return [
        Tracks.build(start),
        Tracks.build(
            start + PERIOD_NS,
            track_id=[3, 4, 5],
            position=[[1.5, -2.25, 0], [10, 20, 0], [0, 0, 0]],
            score=[0.5, 1, 1],
            status=[TrackStatus.CONFIRMED, TrackStatus.COASTING, TrackStatus.TENTATIVE],
        ),
        Tracks.build(start + 3 * PERIOD_NS, track_id=[3], position=[[1.75, -2, 0]]),
    ]


def test_file_holds_what_the_benchmarks_expect(tmp_path):
    path = tmp_path / 'deep' / 'tracks.txt'
    write_mot_text(path, ticks(), PERIOD_NS)
    assert path.read_text() == (
        '2,3,-1,-1,-1,-1,0.500,1.5000,-2.2500,0.0000\n'
        '2,4,-1,-1,-1,-1,1.000,10.0000,20.0000,0.0000\n'
        '4,3,-1,-1,-1,-1,1.000,1.7500,-2.0000,0.0000\n'
    )


@pytest.mark.parametrize('phase_ns', [0, 1, PERIOD_NS // 2, PERIOD_NS - 1])
def test_frames_do_not_depend_on_the_phase_of_the_stamps(tmp_path, phase_ns):
    jitter_ns = (0, 3_000_000, -3_000_000)
    moved = [
        dataclasses.replace(rows, stamp_ns=rows.stamp_ns + by)
        for rows, by in zip(ticks(phase_ns), jitter_ns)
    ]
    write_mot_text(tmp_path / 'a.txt', moved, PERIOD_NS)
    assert [line.split(',')[0] for line in (tmp_path / 'a.txt').open()] == ['2', '2', '4']


coordinate = st.floats(-200, 200, width=32)


@given(st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=8), st.integers(1, 50))
def test_what_is_written_is_read_back(tmp_path_factory, positions, frame):
    path = tmp_path_factory.mktemp('mot') / 'a.txt'
    rows = Tracks.build(
        (frame - 1) * PERIOD_NS + PERIOD_NS // 2,
        track_id=range(1, len(positions) + 1),
        position=[(x, y, 0) for x, y in positions],
    )
    write_mot_text(path, [rows], PERIOD_NS, origin_ns=0)
    (back,) = read_mot_text(path, PERIOD_NS)
    assert back.stamp_ns == rows.stamp_ns
    assert back.track_id.tolist() == rows.track_id.tolist()
    np.testing.assert_allclose(back.position, rows.position, atol=1e-4)


@pytest.mark.parametrize(
    ('line', 'reason'),
    [
        ('1,2,-1,-1,-1,-1,1,0,0', 'line 2: 9 fields, expected 10'),
        ('1,2,-1,-1,-1,-1,1,x,0,0', 'line 2: could not convert'),
        ('1,2,-1,-1,-1,-1,1,nan,0,0', 'line 2: a number is not finite'),
        ('0,2,-1,-1,-1,-1,1,0,0,0', 'line 2: the frame is 0'),
        ('1,2.5,-1,-1,-1,-1,1,0,0,0', 'line 2: the id is 2.5'),
    ],
)
def test_bad_line_is_named(tmp_path, line, reason):
    path = tmp_path / 'bad.txt'
    path.write_text('1,1,-1,-1,-1,-1,1,0,0,0\n' + line + '\n')
    with pytest.raises(MotTextError, match=f'bad.txt, {reason}'):
        read_mot_text(path, PERIOD_NS)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(MotTextError, match=r'none\.txt cannot be read'):
        read_mot_text(tmp_path / 'none.txt', PERIOD_NS)
