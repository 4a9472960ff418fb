"""The report of a run: what it tells is right, it is one page, and its PDF is one."""

import json
import re
import sys
import zlib

import numpy as np
import pytest

from command_line import mctrack
from mctrack_ros.interfaces import EventCode, Events, Ticks, Tracks
from mctrack_ros.recording import BagWriter
from mctrack_ros.recording.bags.definitions import TYPES
from mctrack_ros.report.run.clock import clock
from mctrack_ros.report.run.data import CELL_M, run_data
from mctrack_ros.report.run.page import run_page, write_run_report
from mctrack_ros.store import Database, NewRun, Run, TrajectoryWriter
from mctrack_ros.store.queries.run import ALWAYS
from well_formed import Balanced

BEGAN_NS = 1_700_000_000_000_000_000
PEOPLE = 50
HOSTILE = '"</style><script>alert(1)</script>'
ORIGIN = (1000.0, 0.0)
GAP = range(120, 150)


def people_at(k):
    """Return who is there in tick k: everybody a second later, 3 away from 5 s to 8 s."""
    return [
        who
        for who in range(1, PEOPLE + 1)
        if 10 * who <= 10 * k and (who != 3 or not 50 <= k < 80)
    ]


def place(who, k):
    return who + 0.05 * k, 10.0 + 0.2 * who, 0.0


@pytest.fixture(scope='module')
def database(tmp_path_factory):
    path = tmp_path_factory.mktemp('run') / 'run.db'
    with (
        Database(path, create=True) as opened,
        TrajectoryWriter(opened, NewRun(HOSTILE)) as writer,
    ):
        writer.write_description(json.dumps({'origin': ORIGIN}), BEGAN_NS)
        for k in range(200):
            if k in GAP:
                continue
            ids, stamp = people_at(k), BEGAN_NS + k * 100_000_000
            covariance = np.zeros((len(ids), 4, 4))
            covariance[:, :2, :2] = [[0.04, 0.03], [0.03, 0.04]]
            rows = Tracks.build(
                stamp,
                track_id=[99 if who == 5 and k < 100 else who for who in ids],
                position=[place(who, k) for who in ids] or np.zeros((0, 3)),
                covariance=covariance,
                group=[7 if who in {8, 9} and 60 <= k < 90 else 0 for who in ids],
            )
            writer.write_tracks(rows)
            if k == 100:
                kinds = [EventCode.CORRECTION, EventCode.MERGE]
                writer.write_events(
                    Events.build(
                        stamp, event=kinds, track_id=[5, 8], old_id=[99, 0], new_id=[5, 0]
                    )
                )
    return path


@pytest.fixture(scope='module')
def data(database):
    with Run(database) as run:
        return run_data(run, ALWAYS)


def test_what_is_told_is_what_was(data):
    assert [len(people_at(k)) for k in range(200) if k not in GAP] == data.present.tolist()
    assert len(data.tracks) == PEOPLE
    tracks = {track.summary.track_id: track for track in data.tracks}
    assert np.ravel(tracks[3].spells) == pytest.approx([0.3, 4.9, 8.0, 11.9, 15.0, 19.9])
    assert tracks[3].seconds == pytest.approx(4.6 + 3.9 + 4.9)
    assert tracks[3].times.sum() == pytest.approx(tracks[3].seconds)
    assert tracks[5].spells[0] == pytest.approx((0.5, 11.9))
    first = np.floor(np.add(place(50, 50)[:2], ORIGIN) / CELL_M)
    assert tracks[50].cells[np.lexsort(tracks[50].cells.T)][0] == pytest.approx(first)
    assert [track.seconds for track in data.tracks] == sorted(
        (track.seconds for track in data.tracks), reverse=True
    )
    (corrected,), (group,) = data.corrections, data.groups
    assert (corrected.old_id, corrected.new_id, corrected.time_s) == (99, 5, 10.0)
    assert (group.began_s, group.ended_s, group.members) == (6.0, 8.9, (8, 9))
    assert [event.event for event in data.events] == ['correction', 'merge']
    quality = data.quality
    assert (quality.ticks, quality.missing) == (170, 30)
    assert quality.interval_s == pytest.approx(0.1)
    assert quality.gaps == (pytest.approx((11.9, 15.0)),)
    assert quality.error_m == pytest.approx(np.sqrt([0.07, 0.07]), rel=1e-5)


def test_the_page_is_well_formed_needs_no_network_and_escapes_names(data):
    text = run_page(data, f'mctrack report {HOSTILE}')
    page = Balanced()
    page.feed(text)
    assert page.open == []
    assert all(address.startswith(('data:image/png;base64,', '#')) for address in page.addresses)
    assert not re.search(r'https?:|//[a-z]|@import|url\((?!#)', re.sub(r'base64,[^"]*', '', text))
    assert '<script' not in text
    assert '</style><' not in text.partition('</head>')[0]
    assert '10 shorter ones are not listed: 0:' in text
    assert text.count('<svg') == 4 + 12


@pytest.mark.parametrize('between', [(100.0, 200.0), (0.1, 0.2), (0.1, 0.3)])
def test_nobody_and_one_position_are_told_as_well(database, between):
    with Run(database) as run:
        data = run_data(run, between, title='short')
    text = run_page(data, 'mctrack report run.db')
    assert ('Nobody was tracked in this time.' in text) == (not data.tracks)
    assert len(data.tracks) == {100.0: 0, 0.1: round(10 * between[1]) - 1}[between[0]]


def test_a_bag_tells_of_its_cameras_and_the_site_of_what_they_see(match, tmp_path):
    page = tmp_path / 'page.html'
    code, output, errors = mctrack('report', match.folder, page, '--site', 'pitch5')
    assert code == 0, errors
    assert output == f'wrote {page}\n'
    text = page.read_text()
    assert f'<h1>{match.folder.name}</h1>' in text
    cells = '<td>0.0 %</td><td>98</td><td>196</td><td>2</td><td>4</td><td>2</td><td>0</td>'
    assert f'<td>cam2</td>{cells}' in text
    assert 'seen by two or more' in text
    assert 'mctrack report match' in text


def test_what_diagnostics_said_was_wrong_is_counted(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        for k in range(3):
            stamp = BEGAN_NS + k * 10**9
            bag.write_rows(
                '/tracks', Tracks.build(stamp, track_id=[1], position=[(k, 0, 0)]), 'map'
            )
            ticks = Ticks.build(stamp, camera=[0], alive=[0])
            bag.write_rows('/ticks', ticks, 'map')
            bag.write('/diagnostics', diagnostics(stamp, bad=k > 0), stamp)
    code, _, errors = mctrack('report', tmp_path / 'bag', tmp_path / 'a.html')
    assert code == 0, errors
    text = (tmp_path / 'a.html').read_text()
    assert '<td>/fusion: cam1</td><td>2</td><td>0:01.0</td><td>no images</td>' in text


def diagnostics(stamp_ns, *, bad):
    types = TYPES.types
    seconds, rest = divmod(stamp_ns, 10**9)
    stamp = types['builtin_interfaces/msg/Time'](sec=seconds, nanosec=rest)
    status = types['diagnostic_msgs/msg/DiagnosticStatus'](
        level=2 if bad else 0, name='/fusion: cam1', message='no images', hardware_id='', values=[]
    )
    header = types['std_msgs/msg/Header'](stamp=stamp, frame_id='')
    return types['diagnostic_msgs/msg/DiagnosticArray'](header=header, status=[status])


def test_the_pdf_has_the_same_in_pages(data, tmp_path):
    try:
        import weasyprint  # noqa: F401
    except OSError as error:
        pytest.skip(f'Pango is not installed: {error}')
    write_run_report(data, [tmp_path / 'a.pdf'], 'mctrack report run.db')
    content = (tmp_path / 'a.pdf').read_bytes()
    assert content.startswith(b'%PDF-')
    streams = re.findall(rb'stream\n(x\xda.*?)\nendstream', content, re.DOTALL)
    objects = b''.join(map(zlib.decompress, streams))
    assert 3 <= len(re.findall(rb'/Type /Page\b', objects)) <= 10


def test_what_is_missing_for_a_pdf_is_said_in_one_line(database, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'weasyprint', None)
    code, _, errors = mctrack('report', database, tmp_path / 'a.pdf')
    assert code == 1
    assert errors.count('\n') == 1
    assert 'pip install weasyprint' in errors
    assert 'apt install libpango' in errors
    assert mctrack('report', database, tmp_path / 'a.doc')[0] == 2


def test_times_as_people_read_them():
    assert [clock(each) for each in (0, 59.96, 61.25, 3599.96, 36000)] == [
        '0:00.0',
        '1:00.0',
        '1:01.2',
        '1:00:00.0',
        '10:00:00.0',
    ]
    assert clock(-2.04) == '-0:02.0'
    assert clock(90.4, 0) == '1:30'
