"""What nodes answer when they are asked for help."""

import re
import subprocess
import sys

import pytest

from mctrack_ros.config import parameters_of
from mctrack_ros.ros.default_files import NODE_CONFIGS

STARTER = """
import sys
from mctrack_ros.ros import start
sys.argv[1:] = {arguments}
code = start.{node}()
assert not {{'numba', 'rclpy', 'cv2'}} & sys.modules.keys()
sys.exit(code)
"""


def check(done, node):
    assert done.returncode == 0, done.stderr
    assert done.stderr == ''
    assert done.stdout.startswith(f'usage: {node} --ros-args')
    for parameter in parameters_of(NODE_CONFIGS[node]):
        group = parameter.name.rpartition('.')[0]
        shown = f'{group}.*' if group.count('.') else parameter.name
        assert re.search(rf'^  {re.escape(shown)}: ', done.stdout, re.M) or group.count('.') > 1
    assert f'{node}.yaml' in done.stdout.splitlines()[-1]


@pytest.mark.parametrize('node', NODE_CONFIGS)
@pytest.mark.parametrize('arguments', [['--help'], ['--ros-args', '-h']])
def test_an_executable_says_how_it_is_used_and_loads_nothing_for_it(node, arguments):
    code = STARTER.format(node=node, arguments=arguments)
    command = [sys.executable, '-c', code]
    check(subprocess.run(command, capture_output=True, text=True, timeout=60, check=False), node)


def test_a_module_that_is_run_says_the_same():
    command = [sys.executable, '-m', 'mctrack_ros.ros.nodes.recorder', '--help']
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    check(done, 'recorder')


def test_parameters_far_down_are_counted(monkeypatch, capsys):
    from mctrack_ros.ros.start import camera_node

    monkeypatch.setattr(sys, 'argv', ['/bin/camera_node', '--help'])
    assert camera_node() == 0
    shown = capsys.readouterr().out
    assert "  settings.grid: ''\n" in shown
    assert '  settings.pipeline.*: ' in shown
    assert 'settings.pipeline.tracker' not in shown
    assert len(shown.splitlines()) < 75
