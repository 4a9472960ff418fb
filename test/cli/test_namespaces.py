"""Recordings of graphs in a namespace, cut or whole, by the commands."""

import json

import pytest
import yaml

from command_line import mctrack
from drawn_hall import write_hall
from mctrack_ros.recording import BagReader, BagWriter

pytestmark = pytest.mark.xdist_group('replay')


def renamed(bag, out, names):
    """Copy a bag with its topics under other names."""
    with BagReader(bag) as reader, BagWriter(out) as writer:
        for topic, kind, data, time_ns in reader.serialized():
            writer.write_serialized(names(topic), kind, data, time_ns)
    return out


@pytest.fixture(scope='module')
def hall(tmp_path_factory):
    """Return the folder with a bag, its site, and what it is tracked to."""
    folder = tmp_path_factory.mktemp('hall')
    bag, _ = write_hall(folder, seconds=3.0)
    code, _, errors = mctrack(
        'track', bag, '--out', folder / 'out', '--site', folder / 'site.yaml'
    )
    assert code == 0, errors
    return folder


def tracks_of(folder):
    return (folder / 'tracks.txt').read_text()


@pytest.mark.parametrize('namespace', ['hall', '/hall/'])
def test_a_bag_of_a_namespace_is_tracked_to_the_same(hall, tmp_path, namespace):
    bag = renamed(hall / 'bag', tmp_path / 'bag', lambda topic: f'/hall{topic}')
    site = ('--site', hall / 'site.yaml')
    code, _, errors = mctrack('track', bag, '--out', tmp_path / 'no', *site)
    assert code == 1
    assert 'give --namespace /hall' in errors
    code, _, errors = mctrack(
        'track', bag, '--out', tmp_path / 'out', *site, '--namespace', namespace
    )
    assert code == 0, errors
    assert tracks_of(tmp_path / 'out') == tracks_of(hall / 'out') != ''


def test_whole_names_of_topics_and_capitals_are_tracked_to_the_same(hall, tmp_path):
    bag = renamed(hall / 'bag', tmp_path / 'bag', lambda topic: topic.replace('/north', '/D455_1'))
    site = yaml.safe_load((hall / 'site.yaml').read_text())
    north = site['cameras'].pop('north')
    site['cameras']['D455_1'] = north
    (hall / 'capitals.yaml').write_text(yaml.safe_dump(site))
    site['cameras']['north'] = site['cameras'].pop('D455_1')
    site['cameras']['north'] |= {'image_topic': '/D455_1/image_raw/compressed'}
    (hall / 'whole.yaml').write_text(yaml.safe_dump(site))
    for name in ('capitals', 'whole'):
        code, _, errors = mctrack(
            'track', bag, '--out', tmp_path / name, '--site', hall / f'{name}.yaml'
        )
        assert code == 0, errors
        assert tracks_of(tmp_path / name) == tracks_of(hall / 'out')


def test_echo_and_explain_read_a_namespace(hall, tmp_path):
    bag = renamed(hall / 'out/bag', tmp_path / 'bag', lambda topic: f'/hall{topic}')
    for topic in ('/tracks', 'tracks'):
        command = ('echo', topic, '--bag', bag, '--namespace', 'hall', '--json', '--count', 1)
        code, output, errors = mctrack(*command)
        assert code == 0, errors
        assert json.loads(output)['topic'] == '/tracks'
    lines = tracks_of(hall / 'out').splitlines()
    frame, track_id = lines[-1].split(',')[:2]
    at = ('--track', track_id, '--at', (int(frame) - 1) * 0.04)
    plain = mctrack('explain', hall / 'out/bag', *at)
    inside = mctrack('explain', bag, *at, '--namespace', 'hall')
    assert plain[0] == inside[0] == 0, plain[2] + inside[2]
    assert plain[1] == inside[1]


def test_a_cut_file_is_tracked_up_to_the_cut_with_one_warning(hall, tmp_path):
    """Both with backgrounds given: a first pass over fewer images gives other ones."""
    learned = ('--site', hall / 'site.yaml', '--out', tmp_path)
    code, _, errors = mctrack('background', hall / 'bag', *learned)
    assert code == 0, errors
    site = yaml.safe_load((hall / 'site.yaml').read_text())
    for name, camera in site['cameras'].items():
        camera |= {
            'background': str(tmp_path / f'{name}.png'),
            'calibration': str(hall / camera['calibration']),
        }
    (tmp_path / 'site.yaml').write_text(yaml.safe_dump(site))
    (file,) = (hall / 'bag').glob('*.mcap')
    content = file.read_bytes()
    (tmp_path / 'cut.mcap').write_bytes(content[: int(0.7 * len(content))])
    given = ('--site', tmp_path / 'site.yaml')
    code, _, errors = mctrack('track', hall / 'bag', '--out', tmp_path / 'whole', *given)
    assert code == 0, errors
    code, _, errors = mctrack('track', tmp_path / 'cut.mcap', '--out', tmp_path / 'cut', *given)
    assert code == 0, errors
    assert errors.count('breaks off: it is read until') == 1
    assert 'Traceback' not in errors
    lines, whole = (tracks_of(tmp_path / name).splitlines() for name in ('cut', 'whole'))
    last = int(lines[-1].split(',')[0])
    assert 50 <= last <= 55
    # in the last tick images of one camera may be missing
    before = [line for line in lines if int(line.split(',')[0]) < last - 1]
    assert before == [line for line in whole if int(line.split(',')[0]) < last - 1] != []


@pytest.mark.parametrize(
    'command', ['track', 'echo', 'explain', 'doctor', 'run', 'record', 'play']
)
def test_what_is_no_namespace_is_refused_by_every_command(hall, command):
    bag, out = hall / 'bag', ('--out', hall / 'x')
    given = {
        'track': (bag, *out),
        'echo': ('tracks', '--bag', bag),
        'explain': (bag, '--track', 1, '--at', 0),
        'doctor': (hall / 'site.yaml', bag),
        'run': (hall / 'site.yaml',),
        'record': (hall / 'x',),
        'play': (bag,),
    }
    code, _, errors = mctrack(command, *given[command], '--namespace', 'my hall')
    assert code == 1
    assert errors == (
        "mctrack: namespace 'my hall': expected letters, digits and single underscores, no "
        'digit first in each part, as in /hall\n'
    )
