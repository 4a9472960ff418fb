"""The executables of the nodes while they start."""

import os
import signal
import subprocess
import sys

import pytest

STARTER = 'import sys; from mctrack_ros.ros import start; sys.exit(start.fusion_node())'


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_node_that_is_told_to_end_while_it_imports_ends_without_a_traceback(number):
    command = [sys.executable, '-X', 'importtime', '-c', STARTER]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        said = []
        for line in process.stderr:
            said.append(line)
            if 'llvmlite' in line:
                process.send_signal(number)
                break
        said += process.stderr.readlines()
        assert process.wait(timeout=60) == 0, ''.join(said[-20:])
    assert not [line for line in said if 'Traceback' in line or 'KeyboardInterrupt' in line]


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_node_that_is_told_to_end_while_it_compiles_ends_without_a_traceback(tmp_path, number):
    command = [sys.executable, '-c', STARTER, '--ros-args']
    command += ['-p', 'autostart:=true', '-p', 'cameras:=[cam1]']
    environment = os.environ | {'XDG_CACHE_HOME': str(tmp_path)}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment) as process:
        said = []
        for line in process.stderr:
            said.append(line)
            if 'compiling inner loops' in line:
                process.send_signal(number)
                break
        said += process.stderr.readlines()
        assert process.wait(timeout=60) == -number, ''.join(said[-20:])
    assert not [line for line in said if 'Traceback' in line or 'KeyboardInterrupt' in line]
