"""The supervisor: starts again what dies, stops everything, leaves nothing behind."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from mctrack_ros.ros.graph.supervise import Process, Supervisor

FOREVER = 'import signal, time\nprint("up", flush=True)\nsignal.pause()'
STUBBORN = (
    'import signal\nfor n in (2, 15): signal.signal(n, signal.SIG_IGN)\n'
    'print("up", flush=True)\nwhile True: signal.pause()'
)


def python(name, code, **options):
    return Process(name, (sys.executable, '-c', code), **options)


class Run:
    """A supervisor in a thread of its own."""

    def __init__(self, *processes):
        self.lines = []
        self.supervisor = Supervisor(processes, self.lines.append)
        self.code = None
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self):
        self.code = self.supervisor.run()

    def until(self, condition):
        end = time.monotonic() + 15
        while not condition():
            assert time.monotonic() < end, self.lines
            time.sleep(0.01)

    def stop(self):
        self.supervisor.stop()
        self.thread.join(timeout=90)
        assert not self.thread.is_alive()
        return self.code


@pytest.fixture
def run():
    runs = []

    def start(*processes):
        runs.append(Run(*processes))
        return runs[-1]

    yield start
    for one in runs:
        one.stop()


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_lines_carry_the_name_of_their_process(run):
    started = run(python('one', FOREVER), python('two', FOREVER))
    started.until(lambda: len(started.lines) == 2)
    assert sorted(started.lines) == ['[one] up', '[two] up']


def test_a_killed_process_is_started_again(run):
    started = run(python('one', FOREVER), python('two', FOREVER))
    started.until(lambda: len(started.lines) == 2)
    other = started.supervisor.pids()['two']
    os.kill(started.supervisor.pids()['one'], signal.SIGKILL)
    started.until(lambda: started.lines.count('[one] up') == 2)
    assert started.supervisor.starts() == {'one': 2, 'two': 1}
    assert started.supervisor.pids()['two'] == other
    assert '[one] ended with -9: starting again in 0.5 s' in started.lines


def test_pauses_grow_while_a_process_keeps_dying(run):
    started = run(python('one', 'raise SystemExit(1)'))
    started.until(lambda: started.supervisor.starts()['one'] >= 3)
    pauses = [line.split()[-2] for line in started.lines if 'starting again' in line]
    assert pauses[:2] == ['0.5', '1']


def test_a_wrong_configuration_is_not_tried_again_and_ends_all(run):
    started = run(python('one', 'raise SystemExit(2)'), python('two', FOREVER))
    started.thread.join(timeout=90)
    assert started.code == 1
    assert started.supervisor.starts()['one'] == 1
    assert '[one] failed with 2' in started.lines


def test_all_ends_with_the_process_it_is_about(run):
    started = run(python('one', 'pass', restart=False, ends=True), python('two', FOREVER))
    started.thread.join(timeout=90)
    assert started.code == 0
    assert started.supervisor.codes()['one'] == 0


def test_stopping_leaves_no_process_behind(run):
    started = run(python('one', FOREVER), python('two', FOREVER))
    started.until(lambda: len(started.lines) == 2)
    pids = list(started.supervisor.pids().values())
    assert started.stop() == 0
    assert not any(map(alive, pids))


def test_what_does_not_listen_is_ended_by_force(run, monkeypatch):
    patience = ((signal.SIGTERM, 0.2), (signal.SIGKILL, 5.0))
    monkeypatch.setattr('mctrack_ros.ros.graph.supervise._PATIENCE_S', patience)
    started = run(python('one', STUBBORN))
    started.until(lambda: started.lines == ['[one] up'])
    pid = started.supervisor.pids()['one']
    assert started.stop() == 1
    assert not alive(pid)


def test_what_hangs_says_where(run, monkeypatch):
    patience = ((signal.SIGTERM, 0.2), (signal.SIGABRT, 30.0))
    monkeypatch.setattr('mctrack_ros.ros.graph.supervise._PATIENCE_S', patience)
    started = run(python('one', STUBBORN))
    started.until(lambda: started.lines == ['[one] up'])
    assert started.stop() == 1
    assert '[one] Fatal Python error: Aborted' in started.lines
    assert '[one]   File "<string>", line 4 in <module>' in started.lines
    assert '[one] ended with -6 when asked to stop' in started.lines


def test_a_program_that_is_not_there_is_a_failure(run):
    started = run(Process('one', ('/nowhere/program',)))
    started.thread.join(timeout=90)
    assert started.code == 1
    assert 'cannot start' in started.lines[0]


SUPERVISED_NODE = """
import sys, threading, time
from mctrack_ros.ros.graph.supervise import Process, Supervisor
command = (sys.executable, '-m', 'mctrack_ros.ros.nodes.fusion_node')
supervisor = Supervisor([Process('fusion', command)], print)
threading.Thread(target=supervisor.run).start()
while not supervisor.pids():
    time.sleep(0.01)
print(supervisor.pids()['fusion'], flush=True)
"""


@pytest.mark.live
def test_nodes_end_when_their_supervisor_is_killed(bench):
    bench.open()
    command = [sys.executable, '-c', SUPERVISED_NODE]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as supervisor:
        pid = int(supervisor.stdout.readline())
        bench.until(lambda: bench.observer.count_publishers('/tracks') == 1)
        supervisor.kill()
    bench.until(lambda: not alive(pid))
