"""What nodes answer when they are asked for help."""

import subprocess
import sys

import pytest

from mctrack_ros.config import parameters_of
from mctrack_ros.ros.default_files import NODE_CONFIGS

QUICK = ['recorder', 'player', 'video_node', 'simulator_node']


@pytest.mark.parametrize('node', QUICK)
@pytest.mark.parametrize('arguments', [['--help'], ['--ros-args', '-h']])
def test_a_node_that_is_asked_for_help_names_its_parameters_and_ends(node, arguments):
    command = [sys.executable, '-m', f'mctrack_ros.ros.{node}', *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0
    assert done.stderr == ''
    assert done.stdout.startswith(f'usage: {node} --ros-args')
    for parameter in parameters_of(NODE_CONFIGS[node]):
        assert f'  {parameter.name}: ' in done.stdout
    assert f'{node}.yaml' in done.stdout.splitlines()[-1]


def test_parameters_far_down_are_counted(monkeypatch, capsys):
    from mctrack_ros.ros.camera_node import main

    monkeypatch.setattr(sys, 'argv', ['/bin/camera_node', '--help'])
    assert main() == 0
    shown = capsys.readouterr().out
    assert "  settings.grid: ''\n" in shown
    assert '  settings.pipeline.*: ' in shown
    assert 'settings.pipeline.tracker' not in shown
    assert len(shown.splitlines()) < 60
