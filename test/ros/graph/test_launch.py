"""The launch files, started by ROS's own launch where it is installed."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from drawn_hall import write_hall
from mctrack_ros.interfaces import Tracks, TrackStatus

pytest.importorskip('launch_ros', reason='launch is not among the wheels')
pytestmark = pytest.mark.live

LAUNCH = Path(__file__).resolve().parents[3] / 'launch'
START = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import AnyLaunchDescriptionSource

path, *arguments = sys.argv[1:]
file = AnyLaunchDescriptionSource(path)
values = [argument.split(':=', 1) for argument in arguments]
service = LaunchService()
service.include_launch_description(
    LaunchDescription([IncludeLaunchDescription(file, launch_arguments=values)])
)
sys.exit(service.run())
"""


@pytest.fixture
def launched(bench, tmp_path):
    """Return a function that starts a launch file as `ros2 launch` does; its output is a file."""
    prefixes = [sys.prefix, *filter(None, [os.environ.get('AMENT_PREFIX_PATH')])]

    def start(name, **arguments):
        given = [f'{each}:={value}' for each, value in arguments.items()]
        with open(tmp_path / 'launch.log', 'w') as log:
            process = subprocess.Popen(
                [sys.executable, '-c', START, str(LAUNCH / name), *given],
                env=os.environ | {'AMENT_PREFIX_PATH': os.pathsep.join(prefixes)},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )
        bench.processes.append(process)
        return process

    return start


def has_people(messages):
    return any((rows.status == TrackStatus.CONFIRMED).any() for rows in messages)


@pytest.mark.parametrize('form', ['py', 'xml'])
def test_a_simulation_is_tracked_in_its_namespace_until_ctrl_c(bench, launched, form):
    bench.open()
    tracks = bench.rows(Tracks, '/hall/tracks')
    process = launched(f'simulation.launch.{form}', namespace='hall')
    bench.until(lambda: has_people(tracks))
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    bench.exit_code(process)
    said = bench.log('launch')
    assert 'Traceback' not in said
    assert 'process has died' not in said
    assert 'failed to terminate' not in said


@pytest.mark.parametrize('form', ['py', 'xml'])
def test_a_replay_tracks_a_bag_and_ends_with_it(bench, launched, tmp_path, form):
    write_hall(tmp_path)
    bench.open()
    tracks = bench.rows(Tracks, '/tracks')
    site = tmp_path / 'site.yaml'
    process = launched(f'replay.launch.{form}', site=site, bag=tmp_path / 'bag')
    bench.until(lambda: process.poll() is not None)
    assert process.returncode == 0, bench.log('launch')
    assert has_people(tracks)


@pytest.mark.parametrize('form', ['py', 'xml'])
def test_recorded_detections_are_fused_without_camera_nodes(bench, launched, form):
    bench.open()
    tracks = bench.rows(Tracks, '/tracks')
    bag = LAUNCH.parent / 'bags' / 'pitch5_detections'
    process = launched(f'replay.launch.{form}', site='pitch5', bag=bag, own_detections='true')
    bench.until(lambda: process.poll() is not None)
    said = bench.log('launch')
    assert process.returncode == 0, said
    assert 'camera_node' not in said
    assert has_people(tracks)


def test_a_site_whose_parameters_are_refused_ends_with_the_reason(bench, launched, tmp_path):
    write_hall(tmp_path, seconds=0.1)
    own = tmp_path / 'own.yaml'
    own.write_text('/fusion: {ros__parameters: {fusion.batching.max_wait: -1.0}}')
    process = launched('site.launch.xml', site=tmp_path / 'site.yaml', params_file=own)
    bench.exit_code(process)
    said = bench.log('launch')
    assert 'fusion.batching.max_wait is -1.0, expected 0.0 to' in said
    assert 'shutting down launched system' in said


def test_a_calibration_says_which_file_is_missing(bench, launched, tmp_path):
    process = launched(
        'calibration.launch.xml',
        source=tmp_path / 'hall.jpg',
        scene=tmp_path / 'hall.xml',
        camera='north',
        out=tmp_path / 'north.xml',
    )
    bench.exit_code(process)
    assert 'hall.xml' in bench.log('launch')
