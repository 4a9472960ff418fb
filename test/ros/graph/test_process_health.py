"""What a supervisor says of its processes on /diagnostics."""

import os
import signal
import sys
import threading

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from mctrack_ros.ros.graph.process_health import ProcessHealth
from mctrack_ros.ros.graph.supervise import Process, ProcessState, Supervisor

pytestmark = pytest.mark.live
FOREVER = 'import signal\nprint("up", flush=True)\nsignal.pause()'
WRONG = 'import sys\nprint("no room on /disk", flush=True)\nsys.exit(1)'


def test_a_killed_process_is_named_and_one_that_fails_says_why(bench):
    bench.open()
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    health = ProcessHealth('/hall', bench.domain)
    processes = [
        Process('fusion', (sys.executable, '-c', FOREVER)),
        Process('recorder', (sys.executable, '-c', WRONG), restart=False),
    ]
    supervisor = Supervisor(processes, lambda line: None, look=health.look)
    thread = threading.Thread(target=supervisor.run)
    thread.start()

    def told(name):
        found = [
            s for each in reports for s in each.status if s.name == f'/hall/supervisor: {name}'
        ]
        return [(each.level, each.message) for each in found]

    try:
        bench.until(lambda: (DiagnosticStatus.OK, 'runs') in told('fusion'))
        bench.until(lambda: told('recorder')[-1][0] == DiagnosticStatus.ERROR)
        assert told('recorder')[-1][1] == 'ended with 1: no room on /disk'
        os.kill(supervisor.pids()['fusion'], signal.SIGKILL)
        bench.until(
            lambda: (
                (DiagnosticStatus.ERROR, 'ended with -9: it is started again') in told('fusion')
            )
        )
        bench.until(lambda: told('fusion')[-1][0] == DiagnosticStatus.WARN)
        assert 'ended with -9, was started again' in told('fusion')[-1][1]
    finally:
        supervisor.stop()
        thread.join()
        health.close()


def test_last_words_wait_for_who_hears_them(bench):
    """A process that fails at once does so before others have found its supervisor."""
    health = ProcessHealth('/hall', bench.domain)
    health.look([ProcessState('recorder', False, False, 1, 2, 0.0, 'no room on /disk')])
    closing = threading.Thread(target=health.close)
    closing.start()
    bench.open()
    reports = bench.messages(DiagnosticArray, '/diagnostics')
    closing.join()
    bench.until(lambda: reports)
    assert reports[-1].status[0].message == 'ended with 2: no room on /disk'
