import json
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

import mctrack_ros.streams.formats
from mctrack_ros.interfaces import EventCode, Events, Tracks
from mctrack_ros.streams.formats import trajectory
from mctrack_ros.streams.formats.profiles import all_profiles
from mctrack_ros.streams.formats.text import since_ns, utc
from mctrack_ros.streams.frames import About, Assembler

SCHEMA = Path(mctrack_ros.streams.formats.__file__).parent / 'trajectory.xsd'
NAME = f'{{{trajectory.NAMESPACE}}}'
ABOUT = About('night & day\x07', 'map', (389000.0, 5820000.0))


def document(frames):
    text = ''.join(map(trajectory.xml_frame, frames))
    return trajectory.xml_head(ABOUT) + text + trajectory.XML_TAIL


@pytest.fixture(scope='module')
def schema():
    return etree.XMLSchema(etree.parse(SCHEMA))


def test_what_is_written_fits_the_schema(schema, frames):
    schema.assertValid(etree.fromstring(document(frames).encode()))
    for profile in all_profiles()[:1]:
        message = profile.message(profile.head(ABOUT), profile.frame(frames[1]))
        schema.assertValid(etree.fromstring(message.encode()))


@pytest.mark.parametrize(
    ('word', 'other'),
    [
        ('velocity="0.25 0.0"', 'velocity="0.25"'),
        ('status="confirmed"', ''),
        ('<track id="1"', '<track id="-1"'),
        ('members="1 2"', 'members="you"'),
        ('origin="389000.0 5820000.0"', ''),
    ],
)
def test_the_schema_refuses_what_is_wrong(schema, frames, word, other):
    text = document(frames)
    assert word in text
    assert not schema.validate(etree.fromstring(text.replace(word, other, 1).encode()))


def test_xml_and_json_say_the_same(frames):
    root = etree.fromstring(document(frames).encode())
    head = json.loads(trajectory.json_head(ABOUT))
    assert root.get('run') == 'night & day'
    assert [float(each) for each in root.get('origin').split()] == head['origin']
    for element, frame in zip(root, frames, strict=True):
        values = json.loads(trajectory.json_frame(frame))
        assert element.get('stamp_ns') == str(values.pop('stamp_ns'))
        found = {}
        for one in element:
            name = f'{one.tag.removeprefix(NAME)}s'
            found.setdefault(name, []).append(dict(one.attrib))
        expected = {
            name: [{key: words(value) for key, value in each.items()} for each in listed]
            for name, listed in values.items()
            if listed
        }
        assert found == expected


def words(value):
    listed = value if isinstance(value, list) else [value]
    return ' '.join('NaN' if each is None else str(each) for each in listed)


def test_numbers_are_those_of_the_tracks(frames):
    values = trajectory.frame_values(frames[1])
    rows = frames[1].tracks
    upper = rows.covariance[:, *np.triu_indices(4)]
    for row, track in enumerate(values['tracks']):
        np.testing.assert_allclose(track['position'], rows.position[row], atol=5e-4)
        np.testing.assert_allclose(track['velocity'], rows.velocity[row], atol=5e-3)
        np.testing.assert_allclose(track['covariance'], upper[row], rtol=5e-3)
    assert values['groups'] == [{'id': 1, 'members': [1, 2]}]
    unknown = trajectory.frame_values(frames[5])['tracks'][0]
    assert unknown['position'] == [None, 0.0, 0.0]


def test_an_event_whose_code_is_new_appears_by_its_number(frames):
    split, crossed, emptied, unknown = trajectory.frame_values(frames[6])['events']
    assert (split['code'], split['old'], split['new']) == ('split', 1, 9)
    assert (crossed['code'], crossed['zone_name'], crossed['track']) == (
        'cross_left',
        'ground/1',
        9,
    )
    assert (emptied['code'], emptied['old'], emptied['new']) == ('occupancy', 2, 0)
    assert (unknown['code'], unknown['zone'], unknown.get('zone_name')) == ('code_99', 3, None)
    (correction,) = trajectory.frame_values(frames[3])['corrections']
    assert (correction['old'], correction['new'], correction['probability']) == (3, 7, 0.9)


def test_events_go_with_the_tick_of_their_stamp_or_the_next_one():
    assembler = Assembler(About())
    assert assembler.finish() is None
    ahead, late = Events.build(20, event=[EventCode.NEW]), Events.build(10, event=[EventCode.EXIT])
    assembler.add_events(ahead)
    assert assembler.add_tracks(Tracks.build(10)) is None
    first = assembler.finish()
    assert first.events == ()
    assembler.add_events(late)
    assembler.add_tracks(Tracks.build(20))
    second = assembler.add_tracks(Tracks.build(30))
    assert second.events == (late, ahead)
    assert second.before is first.tracks


def test_who_was_found_again_is_not_forgotten():
    assembler = Assembler(About(lost_ns=20))
    seen = []
    for stamp in range(0, 80, 10):
        there = [5] if stamp in (30, 40) else []
        assembler.add_tracks(Tracks.build(stamp, track_id=there) if there else Tracks.build(stamp))
        if stamp in (10, 50):
            assembler.add_events(Events.build(stamp, event=[EventCode.EXIT], track_id=[5]))
        seen.append(assembler.finish().forgotten)
    assert seen == [(), (), (), (), (), (), (), (5,)]


def test_the_site_says_which_run_it_is():
    said = {'run': 'abc', 'origin': [1, 2], 'fusion': {'reid': {'lost_time': 20.0}}}
    assert About.of_site(json.dumps(said), 'map') == About('abc', 'map', (1.0, 2.0), 20 * 10**9)
    for text in ('', '[]', '{"run": 1}', '{"run": "a", "origin": [1], "fusion": {}}'):
        with pytest.raises(ValueError, match='/site'):
            About.of_site(text, 'map')


def test_times_in_words_and_back():
    stamp = 1_700_000_000_123_456_789
    assert utc(stamp) == '2023-11-14T22:13:20.123456Z'
    assert stamp <= since_ns(utc(stamp)) < stamp + 1000
    assert since_ns('2023-11-14T23:13:20+01:00') == 1_700_000_000_000_000_999
    assert since_ns('1700000000123456789') == stamp
    for text in ('', 'yesterday', '-5', '9' * 30, '²', '1e9'):
        with pytest.raises(ValueError, match='since'):
            since_ns(text)
