"""Tracks go into files of other tools and come back; other people's readers see the same."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from command_line import mctrack
from mctrack_ros.interfaces import ClassCode, EventCode, Events, Tracks, TrackStatus
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tracks.collected import Layout
from mctrack_ros.recording.tracks.formats import FORMATS
from mctrack_ros.recording.tracks.pitch import Pitch
from mctrack_ros.store import Database, NewRun, Run, TrajectoryWriter, View
from mctrack_ros.store.exchange import Export, export_tracks, instants, opened_run

ROOT = Path(__file__).resolve().parents[2]
READERS = ROOT / '.venv-readers' / 'bin' / 'python'
BEGAN_NS = 1_700_000_000_000_000_000
TICKS = 75
BALL = 9
ORIGIN = (389_000.0, 5_820_000.0)
CENTRE = (389_052.5, 5_820_034.0)
PITCH = Pitch(CENTRE, 105.0, 68.0)
AREA = '389000,5820000,389105,5820068'
ENDINGS = {'mot': 'txt', 'pedpy': 'txt', 'epts': 'txt', 'tracab': 'dat', 'mf-json': 'json'}
RESOLUTION = {'epts': 0.001, 'tracab': 0.01, 'parquet': 0.0}
"""Of positions, m; of other formats a tenth of a millimetre."""


def stamp_ns(k):
    """Return stamps of 25 Hz that jitter by 3 ms; the first does not."""
    return BEGAN_NS + k * 40_000_000 + (k * 7 % 4) * 1_000_000


def who_is_there(k):
    """Return ids: one comes late, one is away for 1.6 s, one is first called 14."""
    ids = [1, 2, 3, 4 if k >= 50 else 14, BALL]
    return [who for who in ids if not (who == 1 and k < 5) and not (who == 2 and 20 <= k < 60)]


def place(who, k):
    """Return where somebody is, from the site's origin, m."""
    who = 4 if who == 14 else who
    return 10.0 * who + 0.04 * k, 60.0 - 5.0 * who + 0.021 * k, 1.5 if who == BALL else 0.0


def tick(k):
    ids = who_is_there(k)
    count = len(ids)
    return Tracks.build(
        stamp_ns(k),
        track_id=ids,
        position=[place(who, k) for who in ids],
        velocity=[(1.0, 0.525)] * count,
        covariance=np.arange(16).reshape(4, 4)
        + np.arange(16).reshape(4, 4).T
        + np.zeros((count, 1, 1)),
        class_id=[ClassCode.BALL if who == BALL else ClassCode.PERSON for who in ids],
        kit=[{1: 1, 2: 1, 3: 2, 4: 1, 14: 1, BALL: 2}[who] for who in ids],
        status=[TrackStatus.COASTING if who == 3 else TrackStatus.CONFIRMED for who in ids],
        group=[7 if who == 3 else 0 for who in ids],
        score=[0.75] * count,
    )


def truth(reported=False):
    """Return id, tick -> x, y in the coordinates of files."""
    return {
        (4 if who == 14 and not reported else who, k): tuple(
            np.add(np.float32(place(who, k)[:2]).astype(float), ORIGIN)
        )
        for k in range(TICKS)
        for who in who_is_there(k)
    }


@pytest.fixture(scope='module')
def database(tmp_path_factory):
    path = tmp_path_factory.mktemp('match') / 'match.db'
    correction = Events.build(
        stamp_ns(50), event=[EventCode.CORRECTION], track_id=[4], old_id=[14], new_id=[4]
    )
    with Database(path, create=True) as opened, TrajectoryWriter(opened, NewRun('a')) as writer:
        writer.write_description(json.dumps({'origin': ORIGIN}), BEGAN_NS)
        for k in range(TICKS):
            writer.write_tracks(tick(k))
        writer.write_events(correction)
    return path


@pytest.fixture(scope='module')
def exported(database, tmp_path_factory):
    """Return a folder with the run in every format."""
    folder = tmp_path_factory.mktemp('exported')
    with Run(database) as run:
        for name, form in FORMATS.items():
            path = folder / f'{name}.{ENDINGS.get(name, name)}'
            made = export_tracks(run, path, form, Export(pitch=PITCH))
            assert (made.positions, made.tracks) == (len(truth()), 5)
            assert all(file.is_file() for file in made.files)
            assert made.rate_hz in {None, 25.0}
            assert made.moved_s == (pytest.approx(0.003) if form.has_frames else 0.0)
    return folder


def assert_same(found, expected, tolerance):
    assert found.keys() == expected.keys()
    for key, xy in expected.items():
        assert found[key] == pytest.approx(xy, abs=tolerance), key


@pytest.fixture(scope='module')
def read_by(exported):
    """Return a function that tells what a reader finds; each is asked once."""
    if not READERS.exists():
        pytest.skip('no other readers: make readers installs them')
    answers = {}

    def ask(reader):
        if reader not in answers:
            command = [str(READERS), str(ROOT / 'test' / 'track_readers.py'), reader, exported]
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=200, check=False
            )
            assert done.returncode == 0, done.stderr
            answers[reader] = json.loads(done.stdout)
        return answers[reader]

    return ask


@pytest.mark.parametrize(
    ('reader', 'form', 'first', 'metres'),
    [
        ('kloppy', 'tracab', 1, 0.01),
        ('kloppy', 'epts', 1, 0.01),
        ('floodlight', 'tracab', 0, 0.01),
    ],
)
def test_readers_of_sports_formats_see_the_same(read_by, reader, form, first, metres):
    said = read_by(reader)[form]
    people = {key: xy for key, xy in truth().items() if key[0] != BALL}
    expected = {key: np.subtract(xy, CENTRE) for key, xy in people.items()}
    found = {(who, frame - first): (x * metres, y * metres) for who, frame, x, y in said['rows']}
    assert_same(found, expected, RESOLUTION[form] / 2 + 1e-6)
    if reader == 'kloppy':
        assert (said['rate'], said['away']) == (25, [3])
        x, y, z = place(BALL, TICKS - 1)
        ball = x + ORIGIN[0] - CENTRE[0], y + ORIGIN[1] - CENTRE[1], z
        assert np.multiply(said['ball'], metres) == pytest.approx(ball, abs=0.0051)
    else:
        assert said['pitch'] == [-5250.0, 5250.0, -3400.0, 3400.0]


@pytest.mark.parametrize('form', ['mf-json', 'geojson'])
def test_movingpandas_sees_the_same(read_by, form):
    said = read_by('movingpandas')[form]
    at = {stamp_ns(k): k for k in range(TICKS)}
    found = {(who, at[stamp]): (x, y) for who, stamp, x, y in said['rows']}
    assert_same(found, truth(), 1e-4)
    assert said['pieces'] == 6  # who was away does not walk across


def test_pedpy_sees_the_same(read_by):
    said = read_by('pedpy')['pedpy']
    assert said['rate'] == 25.0
    assert_same({(who, frame): (x, y) for who, frame, x, y in said['rows']}, truth(), 1e-4)


@pytest.mark.parametrize('form', FORMATS)
def test_what_was_written_is_read_again(exported, form):
    path = exported / f'{form}.{ENDINGS.get(form, form)}'
    layout = Layout(40_000_000, BEGAN_NS - 20_000_000, ORIGIN, pitch=PITCH)
    read = FORMATS[form].read(path, layout)
    stamps = [rows.stamp_ns for rows in read]
    is_exact = not FORMATS[form].has_frames
    expected = [stamp_ns(k) if is_exact else BEGAN_NS + k * 40_000_000 for k in range(TICKS)]
    assert stamps == expected
    ball = 5 if form == 'tracab' or form == 'epts' else BALL
    found = {
        (BALL if who == ball else who, k): tuple(np.add(xy, ORIGIN))
        for k, rows in enumerate(read)
        for who, xy in zip(rows.track_id.tolist(), rows.position[:, :2].astype(float).tolist())
    }
    assert_same(found, truth(), max(RESOLUTION.get(form, 1e-4), 1e-4))
    last = read[-1]
    if form not in {'mot', 'pedpy'}:
        assert last.class_id[last.track_id == ball] == [ClassCode.BALL]
    if form in {'csv', 'parquet'}:
        third = last.select(last.track_id == 3)
        assert (third.status[0], third.group[0], third.score[0]) == (TrackStatus.COASTING, 7, 0.75)
        assert third.velocity[0] == pytest.approx((1.0, 0.525))


def test_parquet_loses_nothing(database, exported):
    read = FORMATS['parquet'].read(exported / 'parquet.parquet', Layout(40_000_000, 0, ORIGIN))
    with Run(database) as run:
        for rows, expected in zip(read, instants(run), strict=True):
            assert rows.stamp_ns == expected.stamp_ns
            for name in Tracks.COLUMNS:
                given, wanted = getattr(rows, name), getattr(expected, name)
                assert np.array_equal(given, wanted, equal_nan=given.dtype.kind == 'f'), name


def test_ids_of_the_time_are_written_as_reported(database, tmp_path):
    with Run(database, view=View(corrected=False)) as run:
        export_tracks(run, tmp_path / 'a.csv', FORMATS['csv'])
    read = FORMATS['csv'].read(tmp_path / 'a.csv', Layout(40_000_000))
    assert {who for rows in read for who in rows.track_id.tolist()} == {1, 2, 3, 4, 14, BALL}


def test_a_frame_rate_is_found_and_what_it_costs_is_said(tmp_path):
    with Database(tmp_path / 'a.db', create=True) as database:
        with TrajectoryWriter(database, NewRun('a')) as writer:
            for k in range(50):
                writer.write_tracks(tick(k).at(BEGAN_NS + k * 80_000_000))
        with Run(database) as run:
            made = export_tracks(run, tmp_path / 'a.txt', FORMATS['pedpy'])
            assert (made.rate_hz, made.moved_s, made.left_out) == (12.5, 0.0, 0)
            made = export_tracks(run, tmp_path / 'a.dat', FORMATS['tracab'], Export(pitch=PITCH))
            assert (made.rate_hz, made.left_out) == (13.0, 0)
            assert 0.03 < made.moved_s <= 0.5 / 13
            made = export_tracks(run, tmp_path / 'a.mot', FORMATS['mot'], Export(rate_hz=5.0))
            assert (made.left_out, made.rate_hz) == (29, 5.0)
            assert len({line.split(',')[0] for line in (tmp_path / 'a.mot').open()}) == 21


@pytest.mark.parametrize('form', FORMATS)
def test_a_time_in_which_nobody_was_there(database, tmp_path, form):
    path = tmp_path / 'a'
    with Run(database) as run:
        made = export_tracks(run, path, FORMATS[form], Export((100.0, 101.0), pitch=PITCH))
    assert (made.positions, made.tracks) == (0, 0)
    assert FORMATS[form].read(path, Layout(40_000_000, pitch=PITCH)) == []


@pytest.mark.parametrize('turn', [0, 30, 90, 150, -60])
def test_a_pitch_lies_as_its_corners(turn):
    angle = np.radians(turn)
    along, across = (
        np.array([np.cos(angle), np.sin(angle)]),
        np.array([-np.sin(angle), np.cos(angle)]),
    )
    centre = np.array([40.0, -7.0])
    corners = [
        centre + x * along + y * across for x, y in [(-50, -30), (50, -30), (50, 30), (-50, 30)]
    ]
    for first in range(4):
        pitch = Pitch.from_corners(np.roll(corners, first, axis=0))
        assert (pitch.length, pitch.width) == pytest.approx((100, 60))
        assert pitch.centre == pytest.approx(tuple(centre))
        side = 1.0 if -np.pi / 2 < angle <= np.pi / 2 + 1e-9 else -1.0
        there = pitch.from_ground(np.array([centre + 10 * along + 5 * across]))[0]
        assert there == pytest.approx((10 * side, 5 * side))
        assert pitch.to_ground(there[None])[0] == pytest.approx(centre + 10 * along + 5 * across)


def test_what_is_no_pitch_is_refused():
    for corners in ([(0, 0), (10, 0), (12, 5), (0, 5)], [(0, 0), (9, 0), (4, 5)]):
        with pytest.raises(TableError, match=r'rectangle|four corners'):
            Pitch.from_corners(np.array(corners, float))


FLAT = """<root><FrameRate>10</FrameRate><PitchShortSide>6000</PitchShortSide>
<PitchLongSide>9000</PitchLongSide><Kickoff>2026-05-31 20:45:00</Kickoff></root>"""
PLAIN = '{"FrameRate": 10, "PitchShortSide": 6000, "PitchLongSide": 9000}'


@pytest.mark.parametrize(('name', 'metadata'), [('xml', FLAT), ('json', PLAIN)])
def test_tracab_of_others(tmp_path, name, metadata):
    path = tmp_path / 'a.dat'
    (tmp_path / f'a_metadata.{name}').write_text(metadata)
    path.write_text(
        '100:1,8,7,-4500,-3000,0.00;0,6,7,100,0,1.00;4,1,-1,5550,4400,0.00;:10,20,30,0.5,A,Dead;:\n'
        '102:3,8,7,4500,3000,0.00;:5550,4400,0,0.00,H,Alive;:\n'
    )
    first, second = FORMATS['tracab'].read(path, Layout(40_000_000))
    assert first.track_id.tolist() == [6, 8, 9]
    assert first.position.tolist() == pytest.approx(
        np.array([[46, 30, 0], [0, 0, 0], [45.1, 30.2, 0.3]])
    )
    assert second.position.tolist() == pytest.approx(np.array([[90, 60, 0]]))
    assert second.stamp_ns - first.stamp_ns == 200_000_000
    assert name == 'json' or first.stamp_ns == 1_780_260_300_000_000_000


def test_tracab_that_is_none_names_file_and_line(tmp_path):
    path = tmp_path / 'a.dat'
    path.write_text('1:1,8,7:1,2,3,0,H,Alive;:\n')
    with pytest.raises(TableError, match=r'a_metadata.xml cannot be read'):
        FORMATS['tracab'].read(path, Layout(40_000_000))
    (tmp_path / 'a_metadata.xml').write_text(FLAT)
    with pytest.raises(TableError, match=r'a.dat, line 1'):
        FORMATS['tracab'].read(path, Layout(40_000_000))


EPTS = """<main><Metadata><GlobalConfig><FrameRate>10.0</FrameRate></GlobalConfig>
<Sessions><Session id="s"><Start>2026-05-31T20:45:00.500Z</Start>
<FieldSize><Width>100</Width><Height>60</Height></FieldSize></Session></Sessions>
<Devices><Device id="d"><Sensors><Sensor id="position"><Channels>
<Channel id="x"><Unit>UNIT</Unit></Channel><Channel id="y"><Unit>UNIT</Unit></Channel>
</Channels></Sensor></Sensors></Device></Devices><PlayerChannels>
<PlayerChannel id="ax" playerId="Anna" channelId="x"/>
<PlayerChannel id="ay" playerId="Anna" channelId="y"/>
<PlayerChannel id="bx" playerId="Ben" channelId="x"/>
<PlayerChannel id="by" playerId="Ben" channelId="y"/>
<PlayerChannel id="bh" playerId="Ben" channelId="heart"/></PlayerChannels></Metadata>
<DataFormatSpecifications><DataFormatSpecification startFrame="1" endFrame="2" separator=":">
<StringRegister name="frameCount"/><SplitRegister separator=";"><SplitRegister separator=",">
<PlayerChannelRef playerChannelId="ax"/><PlayerChannelRef playerChannelId="ay"/></SplitRegister>
<SplitRegister separator=","><PlayerChannelRef playerChannelId="bh"/>
<PlayerChannelRef playerChannelId="bx"/><PlayerChannelRef playerChannelId="by"/></SplitRegister>
</SplitRegister><SplitRegister separator=","><BallChannelRef channelId="x"/>
<BallChannelRef channelId="y"/></SplitRegister></DataFormatSpecification>
<DataFormatSpecification startFrame="3" endFrame="9" separator=":">
<StringRegister name="frameCount"/>
<SplitRegister separator=","><PlayerChannelRef playerChannelId="bx"/>
<PlayerChannelRef playerChannelId="by"/></SplitRegister></DataFormatSpecification>
</DataFormatSpecifications></main>"""


def test_epts_of_others(tmp_path):
    path, metadata = tmp_path / 'a.txt', tmp_path / 'a_metadata.xml'
    metadata.write_text(EPTS.replace('UNIT', 'normalized'))
    path.write_text('1:0.5,0.5;180,0,0:NaN,NaN\n2:NaN,NaN;180,1,1:0.5,0.25\n3:0.1,0.5\n')
    read = FORMATS['epts'].read(path, Layout(40_000_000))
    assert [rows.track_id.tolist() for rows in read] == [[1, 2], [2, 3], [2]]
    assert read[0].position[:, :2].tolist() == [[50, 30], [0, 60]]
    assert read[1].position[:, :2].tolist() == [[100, 0], [50, 45]]
    assert read[2].position[:, :2].tolist() == [[10, 30]]
    assert np.diff([rows.stamp_ns for rows in read]).tolist() == [100_000_000] * 2
    assert read[0].stamp_ns == 1_780_260_300_500_000_000
    metadata.write_text(EPTS.replace('UNIT', 'furlong'))
    with pytest.raises(TableError, match='furlong'):
        FORMATS['epts'].read(path, Layout(40_000_000))


@pytest.mark.parametrize(
    'text',
    [
        '[]',
        '{',
        '{"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": null}]}',
        '{"type": "Feature", "geometry": {"type": "LineString", "coordinates": [[0, 0], [1, 1]]},'
        ' "properties": {"datetimes": [0]}}',
    ],
)
def test_json_that_holds_no_moving_features(tmp_path, text):
    path = tmp_path / 'a.json'
    path.write_text(text)
    with pytest.raises(TableError, match='no moving features'):
        FORMATS['mf-json'].read(path, Layout(40_000_000))


def test_times_of_moving_features(tmp_path):
    path = tmp_path / 'a.json'
    times = '["1970-01-01T01:00:00.5+01:00", "1970-01-01T00:00:01", 1500]'
    path.write_text(
        '{"type": "Feature", "id": "bus", "temporalGeometry": {"type": "MovingPoint", '
        f'"coordinates": [[0, 0], [1, 2, 3], [4, 5]], "datetimes": {times}}}}}'
    )
    read = FORMATS['mf-json'].read(path, Layout(40_000_000))
    assert [rows.stamp_ns for rows in read] == [500_000_000, 1_000_000_000, 1_500_000_000]
    assert read[1].position.tolist() == [[1, 2, 3]]
    assert read[0].track_id.tolist() == [1]


def test_the_command_line_there_and_back(database, tmp_path):
    bag, again = tmp_path / 'bag', tmp_path / 'again.db'
    code, output, errors = mctrack('export', database, tmp_path / 'a.dat', '--pitch', AREA)
    assert code == 0, errors
    assert 'a_metadata.xml: 330 positions of 5 tracks' in output
    assert '25 frames a second; times were moved by at most 3.0 ms' in output
    code, output, errors = mctrack(
        'import-tracks', tmp_path / 'a.dat', '--bag', bag, '--database', again, '--pitch', AREA
    )
    assert code == 0, errors
    assert '330 positions of 5 tracks' in output
    with BagReader(bag) as reader:
        last = [rows for rows, _ in reader.rows('/tracks', Tracks)][-1]
    assert last.position[last.track_id == 3][0] == pytest.approx(place(3, TICKS - 1), abs=0.0051)
    for source in (bag, again):
        with opened_run(source) as run:
            assert run.origin() == ORIGIN  # whole kilometres: float32 keeps the positions
            assert run.name == 'a'
            assert sum(len(rows) for rows in instants(run)) == len(truth())


def test_the_command_line_says_what_is_missing(database, tmp_path):
    def complaint(*arguments):
        code, _, errors = mctrack(*arguments)
        assert code
        return errors

    assert '--format mot, csv' in complaint('export', database, tmp_path / 'a.txt')
    assert 'expected one of mot' in complaint('export', database, tmp_path / 'a', '--format', 'x')
    assert '--pitch x0,y0,x1,y1' in complaint('export', database, tmp_path / 'a.dat')
    assert 'whole number' in complaint(
        'export', database, tmp_path / 'a.dat', '--pitch', AREA, '--rate', '12.5'
    )
    assert '--bag BAG' in complaint('import-tracks', tmp_path / 'a.csv')
    far = tmp_path / 'far.csv'
    far.write_text('time,id,x,y\n1,1,389000,5820000\n')
    bag = tmp_path / 'bag'
    assert 'from the origin of pitch5' in complaint(
        'import-tracks', far, '--bag', bag, '--site', 'pitch5'
    )
    far.write_text('time,id,x,y\n')
    assert 'no tracks' in complaint('import-tracks', far, '--bag', bag)
    assert not bag.exists()
