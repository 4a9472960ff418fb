import json

import pytest
from lxml import etree
from typer.testing import CliRunner

from mctrack_ros.cli.main import app
from mctrack_ros.recording import BagWriter
from stream_story import ABOUT, SITE, story


def run(*arguments):
    """Run `mctrack`; return what it printed."""
    done = CliRunner().invoke(app, [str(each) for each in arguments], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


@pytest.fixture
def bag(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write_text('/site', json.dumps(SITE), 0)
        for tracks, events in story():
            writer.write_rows('/tracks', tracks, 'map', tracks.stamp_ns)
            if events is not None:
                writer.write_rows('/events', events, 'map', tracks.stamp_ns)
    return tmp_path / 'bag'


def test_a_bag_and_its_database_give_the_same_streams(bag, tmp_path):
    database = tmp_path / 'tracks.db'
    run('store', bag, database)
    written = {}
    for source in (bag, database):
        names = {name: tmp_path / f'{source.name}.{name}' for name in ('xml', 'json', 'onvif')}
        options = [word for name, path in names.items() for word in (f'--{name}', path)]
        assert '9 ticks' in run('stream', source, *options, '--geo', '52.5,13.2')
        written[source] = [path.read_text() for path in names.values()]
    assert written[bag] == written[database]
    xml, lines, onvif = written[bag]
    assert len(etree.fromstring(xml.encode())) == 9
    assert json.loads(lines.splitlines()[0])['run'] == ABOUT.run
    assert 'lat="52.' in onvif


def test_it_must_be_said_what_to_write(bag):
    done = CliRunner().invoke(app, ['stream', str(bag)])
    assert done.exit_code == 2
    assert '--onvif' in done.output
