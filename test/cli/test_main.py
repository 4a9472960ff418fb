import json
import re
import shutil
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from command_line import mctrack
from drawn_hall import write_hall
from mctrack_ros import __version__
from mctrack_ros.cli.commands.database.store import store_results
from mctrack_ros.cli.main import app
from mctrack_ros.recording import BagReader, BagWriter
from mctrack_ros.store import Database, runs

COMMANDS = [command.name for command in app.registered_commands]
pytestmark = pytest.mark.xdist_group('replay')


@pytest.fixture(scope='module')
def tracked(tmp_path_factory):
    """Return the folder with a tracked bag of one and a half seconds and its site."""
    folder = tmp_path_factory.mktemp('hall')
    bag, _ = write_hall(folder, seconds=3.0)
    figures = folder / 'figures.json'
    command = [sys.executable, '-m', 'mctrack_ros.cli.main', 'track', bag, '--json', figures]
    command += ['--out', folder / 'out', '--site', folder / 'site.yaml']
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert 'realtime_factor' in done.stdout
    return folder


@pytest.mark.parametrize('command', COMMANDS)
def test_every_command_explains_itself(command):
    result = CliRunner().invoke(app, [command, '--help'])
    assert result.exit_code == 0
    assert 'Usage:' in result.output


def test_the_version_is_shown():
    assert CliRunner().invoke(app, ['--version']).output.split() == ['mctrack', __version__]


def test_track_writes_figures_that_a_machine_reads(tracked):
    content = json.loads((tracked / 'figures.json').read_text())
    assert content['figures']['ticks'] == 75
    assert content['figures']['images'] == 150
    assert content['protocol']['site'] == 'hall'


def test_track_says_which_site_it_takes_if_none_is_given(tracked, tmp_path):
    code, _, errors = mctrack('track', tracked / 'bag', '--out', tmp_path / 'out')
    assert code == 1
    assert '--site is not given: the shipped pitch5 is taken' in errors


NEED_CAMERAS = {
    'background': ('bag', '--site', 'SITE', '--out', 'plates'),
    'check-calibration': ('SITE',),
    'coverage': ('SITE',),
    'explain': ('bag', '--track', '1', '--at', '2', '--site', 'SITE'),
    'import-detections': ('bag', 'north=boxes.csv', '--site', 'SITE'),
    'track': ('bag', '--site', 'SITE', '--out', 'out'),
}


@pytest.mark.parametrize('command', NEED_CAMERAS)
def test_what_needs_cameras_says_which_cells_have_some(tmp_path, command):
    site = tmp_path / 'halls.yaml'
    site.write_text('cells: [north, south]')
    given = [str(site) if each == 'SITE' else each for each in NEED_CAMERAS[command]]
    code, _, errors = mctrack(command, *given)
    assert code == 1
    assert 'has cells, no cameras: take the site of one of them (north, south)' in errors


def runs_in(database):
    with Database(database) as opened:
        return [each.run for each in runs(opened)]


def test_a_run_is_called_as_the_folder_of_its_results_with_a_number_if_that_is_taken(
    tracked, tmp_path
):
    database = tmp_path / 'hall.db'
    for names in (['out'], ['out', 'out-2']):
        store_results(tracked / 'out', database, 'hall', overwrite=False)
        assert sorted(runs_in(database)) == names
    store_results(tracked / 'out', database, 'hall', overwrite=True)
    assert runs_in(database) == ['out']
    other = tmp_path / 'out'
    shutil.copytree(tracked / 'out', other)
    with BagReader(tracked / 'out/bag') as bag, BagWriter(other / 'bag', overwrite=True) as copy:
        for topic, message, log_ns in bag.messages(['/tracks']):
            copy.write(topic, message, log_ns)
    store_results(other, database, 'hall', overwrite=True)
    assert sorted(runs_in(database)) == ['out', 'out-2']  # that of another folder is kept


def test_track_names_the_run_and_says_before_the_work_that_there_is_one(tracked, tmp_path):
    database, out = tmp_path / 'hall.db', tmp_path / 'again'
    command = ['track', tracked / 'bag', '--out', out, '--site', tracked / 'site.yaml']
    assert mctrack(*command, '--run', 'final')[0] == 2
    command += ['--store', database]
    for further in ([], ['--overwrite']):
        code, output, errors = mctrack(*command, '--run', 'final', *further)
        assert code == 0, errors
        assert re.search(f'stored run final in .*{database.name}', output)
        assert runs_in(database) == ['final']
    shutil.rmtree(out)
    code, _, errors = mctrack(*command, '--run', 'final')
    assert code == 1
    assert 'run final is in' in errors
    assert not out.exists()
    assert mctrack('query', database, 'tracks', '--run', 'final')[0] == 0


def test_echo_prints_a_cloud_of_a_bag_as_a_table(tracked):
    code, output, _ = mctrack('echo', '/ticks', '--bag', tracked / 'out/bag', '--count', 1)
    assert code == 0
    assert re.search(r'/ticks  t = 1000\.\d+ s  2 rows', output)
    assert 'dropped_detections' in output


def test_echo_prints_json_without_nan(tracked):
    code, output, _ = mctrack('echo', '/ticks', '--bag', tracked / 'out/bag', '--json')
    lines = [json.loads(line, parse_constant=pytest.fail) for line in output.splitlines()]
    assert code == 0
    assert len(lines) == 75
    assert lines[0]['fields']['x'] == [None, None]


@pytest.mark.parametrize(
    ('arguments', 'reason'),
    [
        (['track', 'nowhere', '--out', 'out'], 'nowhere does not exist'),
        (['track', '{bag}', '--out', '{out}', '--site', '{site}'], 'exists already'),
        (
            ['track', '{bag}', '--out', 'x', '--site', 'atlantis'],
            "no site 'atlantis' is shipped, only carpark, grey_carpark, hall, indoor, pitch5",
        ),
        (['track', '{bag}', '--out', 'x'], 'its cameras are north, south; give the site'),
        (['echo', '/nothing', '--bag', '{bag}'], 'has no topic /nothing'),
        (['echo', '/site', '--bag', '{out}/bag'], '/site holds std_msgs/msg/String'),
        (['play', 'nowhere'], 'nowhere does not exist'),
        (['import-videos', 'x', 'north.mp4'], 'expected a camera and its value, for example'),
        (['import-videos', 'x', 'north__1=a.mp4'], "camera 'north__1': expected letters, digits"),
        (['import-videos', 'x', 'north=a.mp4'], 'a.mp4 does not exist'),
        (['import-videos', 'x', 'a=a.mp4', '--later', 'a=soon'], "has 'soon', expected seconds"),
        (['import-videos', 'x', 'a=a.mp4', '--later', 'b=1'], '--later names b'),
        (['run', 'nowhere.yaml'], 'nowhere.yaml: No such file'),
        (['reproduce', 'pets', '--live'], 'pets has no live run: leave --live away'),
    ],
)
def test_bad_input_is_one_clear_line(tracked, tmp_path, arguments, reason):
    names = {'bag': tracked / 'bag', 'out': tracked / 'out', 'site': tracked / 'site.yaml'}
    names = {key: str(value) for key, value in names.items()}
    filled = [a.format(**names) for a in arguments]
    filled = [str(tmp_path / 'x') if a == 'x' else a for a in filled]
    code, _, errors = mctrack(*filled)
    assert code == 1
    lines = [line for line in errors.splitlines() if line.startswith('mctrack: ')]
    assert len(lines) == 1
    assert reason in lines[0]
    assert 'Traceback' not in errors


def test_a_number_out_of_range_is_refused_by_its_option():
    result = CliRunner().invoke(app, ['play', 'bag', '--rate', '-1'])
    assert result.exit_code == 2
    assert '--rate' in re.sub(r'\x1b\[[0-9;]*m', '', result.output)


def test_bicycles_come_to_the_car_park_only(rendering_here, tmp_path):
    bag = tmp_path / 'bag'
    code, _, errors = mctrack('simulate', bag, '--bicycles', '--seconds', 1)
    assert code == 2
    assert 'carpark' in errors
    assert not bag.exists()
    scene = ('--scene', 'carpark', '--bicycles', '--seconds', 2)
    code, _, errors = mctrack('simulate', bag, *scene)
    assert code == 0, errors
    assert (bag / 'metadata.yaml').exists()
