import math
import os
import stat
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from mctrack_ros.config import ConfigError
from mctrack_ros.site.site import load_site, site_from
from mctrack_ros.zones.files import read_zones, save_zones, zones_from
from mctrack_ros.zones.shapes import MOST, MOST_POINTS, Line, Zone, Zones

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4]]
BOW = [[0, 0], [4, 4], [4, 0], [0, 4]]
SITE = """\
# A hall.
name: hall   # its name

zones:       # drawn by hand
  old: {corners: [[0, 0], [1, 0], [1, 1]]}   # of before

  # this one, too
  older:
    corners:
      - [0, 0]
      - [2, 0]
      - [2, 1]
# cameras of the hall
cameras:
  north: {calibration: view.yaml}  # the only one
# the end
"""
DRAWN = Zones(
    (
        Zone('Haus & Hof: "Süd"', ((0.5, 0.0), (4.0, 0.0), (4.0, 4.25)), 30.0, 4, 0.9),
        Zone('on', ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))),
    ),
    (Line('door', ((0.0, 0.0), (0.0, 2.0))),),
)


def test_zones_and_lines_of_a_site_are_read_with_their_settings():
    content = {
        'zones': {
            'box': {'corners': SQUARE, 'dwell_s': 20, 'limit': 3, 'probability': 0.9},
            'all': {'corners': SQUARE},
        },
        'lines': {'door': {'points': [[0, 0], [0, 2.5]]}},
    }
    corners = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
    assert zones_from(content) == Zones(
        (Zone('box', corners, 20.0, 3, 0.9), Zone('all', corners)),
        (Line('door', ((0.0, 0.0), (0.0, 2.5))),),
    )


def test_the_description_gives_the_same_back_and_counts_from_one():
    described = DRAWN.described()
    assert [(each['index'], each['name']) for each in described] == [
        (1, 'Haus & Hof: "Süd"'),
        (2, 'on'),
        (3, 'door'),
    ]
    assert Zones.from_description(described) == DRAWN


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        ({'zones': [1]}, r'zones is \[1\], expected a mapping by name'),
        ({'zones': {'box': None}}, 'zones.box is None, expected a mapping with corners'),
        ({'zones': {'box': {}}}, 'zones.box.corners is None, expected 3 to 100 points'),
        ({'zones': {'box': {'corners': SQUARE[:2]}}}, 'zones.box.corners has 2 points'),
        ({'zones': {'box': {'corners': BOW}}}, 'zones.box.corners crosses or touches itself near'),
        ({'zones': {'box': {'corners': [[0, 0], [1, 1], [2, 2]]}}}, 'corners has no area'),
        ({'zones': {'box': {'corners': [*SQUARE, [0, 4]]}}}, 'corners has a corner twice'),
        ({'zones': {'box': {'corners': [[0, 0], [1, math.nan], [2, 2]]}}}, 'finite'),
        ({'zones': {'box': {'corners': [[0, 0], [1, 10**400], [2, 2]]}}}, 'finite'),
        ({'zones': {'box': {'corners': [[0, 0], [1, True], [2, 2]]}}}, 'expected points x, y'),
        ({'zones': {'box': {'corners': [[0, 0], [1, 2, 3], [2, 2]]}}}, 'expected points x, y'),
        ({'zones': {'box': {'corners': [[0, 0]] * 101}}}, 'has 101 points, expected 3 to 100'),
        ({'zones': {'box': {'corners': SQUARE, 'colour': 1}}}, 'unknown key zones.box.colour'),
        ({'zones': {'box': {'corners': SQUARE, 'dwell_s': -1}}}, 'zones.box.dwell_s is -1'),
        ({'zones': {'box': {'corners': SQUARE, 'limit': 0.5}}}, 'zones.box.limit is 0.5'),
        ({'zones': {'box': {'corners': SQUARE, 'probability': 1}}}, 'box.probability is 1'),
        ({'zones': {True: {'corners': SQUARE}}}, 'zones: the name True is none'),
        ({'zones': {'a\nb': {'corners': SQUARE}}}, 'zones: the name'),
        ({'zones': {'': {'corners': SQUARE}}}, 'zones: the name'),
        ({'zones': {'x' * 65: {'corners': SQUARE}}}, 'expected up to 64 printable'),
        ({'zones': {f'{n}': {} for n in range(MOST + 1)}}, 'are 65, expected at most 64'),
        ({'lines': {'door': {'points': [[0, 0]]}}}, 'lines.door.points has 1 points'),
        ({'lines': {'door': {'points': [[0, 0], [0, 0]]}}}, 'lines.door.points has a point twice'),
        ({'lines': {'door': {'points': BOW}}}, 'the line crosses or touches itself'),
        ({'lines': {'door': {'points': SQUARE, 'limit': 1}}}, 'unknown key lines.door.limit'),
        (
            {'zones': {'a': {'corners': SQUARE}}, 'lines': {'a': {'points': SQUARE}}},
            'zones.a: a line has the same name',
        ),
    ],
)
def test_wrong_zones_are_refused_by_key(content, reason):
    with pytest.raises(ConfigError, match=reason) as refusal:
        zones_from(content)
    assert '\n' not in str(refusal.value)
    assert len(str(refusal.value)) < 200


@pytest.mark.parametrize('name', ['zones', 'lines'])
def test_equal_names_are_refused_by_file(tmp_path, name):
    path = tmp_path / 'site.yaml'
    path.write_text(f'{name}:\n  a: {{}}\n  a: {{}}\n')
    with pytest.raises(ConfigError, match=r'site\.yaml: .*a stands twice'):
        read_zones(path)


def test_zones_far_from_the_cameras_are_refused(tmp_path):
    (tmp_path / 'view.yaml').write_text(
        'image_from_ground: [[20, 1, 300], [0.5, -8, 400], [0, 0.02, 1]]'
    )
    content = {
        'cameras': {'north': {'calibration': 'view.yaml'}},
        'lines': {'door': {'points': [[389000, 5820000], [389000, 5820010]]}},
    }
    with pytest.raises(ConfigError, match=r'lines\.door\.points lies 5833 km from the site'):
        site_from(content, tmp_path)
    near = content | {'origin': '389000,5820000'}
    door = site_from(near, tmp_path).own_zones.lines[0]
    assert door.points == ((0.0, 0.0), (0.0, 10.0))


@pytest.fixture
def hall(tmp_path):
    """Return the path of a site with comments."""
    path = tmp_path / 'hall.yaml'
    path.write_text(SITE, newline='')
    return path


def test_saved_zones_are_read_again_and_nothing_else_changes(hall):
    hall.chmod(0o640)
    save_zones(hall, DRAWN)
    assert read_zones(hall) == DRAWN
    text = hall.read_text()
    head, tail = SITE.split('zones:')[0], SITE[SITE.index('# cameras of') :]
    assert text.startswith(head)
    for line in tail.splitlines():
        assert line in text.splitlines()
    assert 'old' not in text
    assert stat.S_IMODE(hall.stat().st_mode) == 0o640
    assert os.listdir(hall.parent) == ['hall.yaml']
    save_zones(hall, Zones())
    assert hall.read_text() == head + tail


@pytest.mark.parametrize(
    'text',
    [
        'cameras: {}',
        'cameras: {}\r\nname: hall\r\n',
        'zones:\nlines: ~\ncameras: {}\n',
        'name: |\n  a\n  hall\n# end\n',
        'a: &a [1]\nb: *a\n',
        '---\ncameras: {}\n...\n',
        'zones: {a: {corners: [[0, 0], [1, 0],\n  [1, 1]]}}\ncameras:\n  # none\n',
        'cameras: {}\nlines:\n  x: {points: [[0, 0],\n   [1, 1]]}\n\n# last',
    ],
)
def test_zones_are_saved_into_any_site_and_taken_out_again(tmp_path, text):
    path = tmp_path / 'site.yaml'
    path.write_text(text, newline='')
    rest = {k: v for k, v in yaml.safe_load(text).items() if k not in ('zones', 'lines')}
    save_zones(path, DRAWN)
    assert read_zones(path) == DRAWN
    drawn = path.read_bytes()
    assert drawn.count(b'\r') in (0, drawn.count(b'\n'))
    save_zones(path, DRAWN)
    assert path.read_bytes() == drawn
    save_zones(path, Zones())
    assert (yaml.safe_load(path.read_text()) or {}) == rest


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('{cameras: {}}', 'do not stand on lines of their own'),
        ('zones: {a: &a {}}\nb: *a\n', 'write them by hand'),
        ('just a word', 'expected a mapping'),
        ('a: 1\n---\nb: 2\n', 'several documents'),
    ],
)
def test_a_file_that_cannot_take_zones_stays_as_it_is(tmp_path, text, reason):
    path = tmp_path / 'site.yaml'
    path.write_text(text)
    with pytest.raises(ConfigError, match=rf'site\.yaml: .*{reason}') as refusal:
        save_zones(path, DRAWN)
    assert '\n' not in str(refusal.value)
    assert path.read_text() == text


@pytest.mark.parametrize(
    'zones',
    [
        Zones((Zone('bow', tuple(map(tuple, BOW))),)),
        Zones((Zone('nan', ((0.0, 0.0), (1.0, math.nan), (2.0, 2.0))),)),
        Zones((DRAWN.zones[1], DRAWN.zones[1])),
        Zones(tuple(Zone(f'{n}', DRAWN.zones[1].corners) for n in range(MOST + 1))),
        Zones(lines=(Line('long', tuple((float(n), 0.0) for n in range(MOST_POINTS + 1))),)),
    ],
)
def test_wrong_zones_are_not_saved(hall, zones):
    with pytest.raises(ConfigError, match=r'hall\.yaml: (zones|lines|two zones)'):
        save_zones(hall, zones)
    assert hall.read_text() == SITE


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r'nowhere\.yaml: No such file'):
        save_zones(tmp_path / 'nowhere.yaml', DRAWN)


@given(st.text(st.characters(exclude_categories=['C', 'Z']), min_size=1, max_size=64))
def test_any_printable_name_is_kept(tmp_path_factory, name):
    path = tmp_path_factory.mktemp('named') / 'site.yaml'
    path.write_text('cameras: {}\n')
    zones = Zones((Zone(name, DRAWN.zones[1].corners),))
    save_zones(path, zones)
    assert read_zones(path) == zones


def test_shipped_sites_keep_their_text_when_zones_are_drawn_and_deleted(tmp_path):
    shipped = Path(__file__).resolve().parents[2] / 'config/pitch5.yaml'
    copy = tmp_path / 'pitch5.yaml'
    copy.write_bytes(shipped.read_bytes())
    save_zones(copy, DRAWN)
    assert read_zones(copy) == DRAWN
    save_zones(copy, read_zones(shipped))
    assert load_site(shipped).zones == read_zones(copy)
