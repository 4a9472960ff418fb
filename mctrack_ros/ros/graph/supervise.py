"""Keep a set of processes running: start, watch, start again, stop."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import IO, NamedTuple

from mctrack_ros.ros.graph.shared_memory import remove_leftovers

BAD_CONFIGURATION = 2
"""Exit code of a process that would fail again."""

PARENT_VARIABLE = 'MCTRACK_PARENT'
"""Tells a node whose child it is; it ends when that process is gone."""

_POLL_S = 0.05
_FIRST_PAUSE_S = 0.5
_LONGEST_PAUSE_S = 10.0
_HEALTHY_S = 10.0
_PATIENCE_S = ((signal.SIGTERM, 7.0), (signal.SIGABRT, 1.0), (signal.SIGKILL, 2.0))
"""
Signals that end a process. SIGINT would end one that still starts with a traceback; SIGABRT lets
one that hangs say where.
"""


@dataclass(frozen=True, slots=True)
class Process:
    """
    One process of a graph.

    Attributes
    ----------
    name : str
        Before each of its lines.
    command : tuple of str
        Program and arguments.
    restart : bool
        Whether it is started again when it dies; one that is not may end with 0.
    ends : bool
        Whether everything stops when it ends.
    takes_keys : bool
        Whether its standard input is a pipe; see `Supervisor.press`.

    """

    name: str
    command: tuple[str, ...]
    restart: bool = True
    ends: bool = False
    takes_keys: bool = False


@dataclass(slots=True)
class _Child:
    """A process as it runs, and when it may run again."""

    process: Process
    running: subprocess.Popen[str] | None = None
    began_s: float = 0.0
    pause_s: float = _FIRST_PAUSE_S
    again_s: float | None = None
    starts: int = 0
    code: int | None = None
    said: str = ''
    threads: list[threading.Thread] = field(default_factory=list)


class ProcessState(NamedTuple):
    """
    How a process is.

    Attributes
    ----------
    name : str
    is_running, is_awaited : bool
        Whether it runs; if not, whether it will be started again.
    starts : int
        How often it was started.
    code : int or None
        Its last exit code; negative: the signal that ended it. None: it has not ended yet.
    up_s : float
        How long it has been running, s.
    said : str
        The last line of its output.

    """

    name: str
    is_running: bool
    is_awaited: bool
    starts: int
    code: int | None
    up_s: float
    said: str


class Supervisor:
    """
    Run processes until a signal to stop, and leave none behind.

    Parameters
    ----------
    processes : sequence of Process
        What to run.
    write : callable
        Takes each line of output, the name of its process before it.
    environment : mapping of str to str, optional
        Laid over the own environment.
    look : callable, optional
        Told again and again how the processes are.

    Attributes
    ----------
    failures : list of str
        What went wrong with which process.

    """

    def __init__(
        self,
        processes: Sequence[Process],
        write: Callable[[str], None],
        environment: Mapping[str, str] | None = None,
        look: Callable[[Sequence[ProcessState]], None] = lambda states: None,
    ) -> None:
        self._write, self._look = write, look
        own = {'PYTHONUNBUFFERED': '1', 'PYTHONFAULTHANDLER': '1'}
        own |= {PARENT_VARIABLE: str(os.getpid())}
        self._environment = {**os.environ, **own, **(environment or {})}
        self._children = [_Child(process) for process in processes]
        self._stopping = threading.Event()
        self._killed = False
        self.failures: list[str] = []

    def stop(self) -> None:
        """Let `run` end; may be called from a signal handler or another thread."""
        self._stopping.set()

    def start(self) -> None:
        """Start every process."""
        for child in self._children:
            self._start(child)

    def run(self) -> int:
        """
        Start everything, watch it until a signal to stop, stop it.

        Returns
        -------
        int
            0, or 1 if something failed.

        """
        try:
            self.start()
            while not self._stopping.wait(_POLL_S):
                is_over = not any([self._watch(child) for child in self._children])
                self._look(self.states())
                if is_over:
                    break
        finally:
            self.stop_all()
        return int(bool(self.failures))

    def pids(self) -> dict[str, int]:
        """Return the process ids of what runs, by name."""
        return {c.process.name: c.running.pid for c in self._children if c.running is not None}

    def starts(self) -> dict[str, int]:
        """Return how often each process was started."""
        return {child.process.name: child.starts for child in self._children}

    def states(self) -> list[ProcessState]:
        """Return how the processes are."""
        now_s = time.monotonic()
        return [
            ProcessState(
                child.process.name,
                child.running is not None,
                child.again_s is not None,
                child.starts,
                child.code,
                now_s - child.began_s if child.running is not None else 0.0,
                child.said,
            )
            for child in self._children
        ]

    def codes(self) -> dict[str, int]:
        """Return the last exit code of each process that ended, by name."""
        return {c.process.name: c.code for c in self._children if c.code is not None}

    def press(self, key: str) -> None:
        """Hand a key to the processes that take some."""
        for child in self._children:
            if child.running is not None and child.running.stdin is not None:
                with suppress(OSError, ValueError):  # it has just ended
                    child.running.stdin.write(key)
                    child.running.stdin.flush()

    def stop_all(self) -> None:
        """End what runs, at last by force."""
        for number, patience_s in _PATIENCE_S:
            alive = [c for c in self._children if c.running and c.running.poll() is None]
            if not alive:
                break
            for child in alive:
                _signal_group(child, number)
            _wait_all(alive, patience_s)
        for child in self._children:
            if child.running is not None:
                self._reap(child, child.running.wait(), stopping=True)
        if self._killed:
            remove_leftovers()

    def _start(self, child: _Child) -> None:
        process = child.process
        try:
            child.running = subprocess.Popen(
                process.command,
                stdin=subprocess.PIPE if process.takes_keys else subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors='replace',
                env=self._environment,
                process_group=0,
            )
        except OSError as error:
            self._fail(f'[{process.name}] cannot start: {error}')
            return
        child.began_s, child.again_s = time.monotonic(), None
        child.starts += 1
        arguments = (child, child.running.stdout)
        thread = threading.Thread(target=self._forward, args=arguments, daemon=True)
        thread.start()
        child.threads.append(thread)

    def _forward(self, child: _Child, lines: IO[str]) -> None:
        with lines:
            for line in lines:
                child.said = line.strip() or child.said
                self._write(f'[{child.process.name}] {line.rstrip()}')

    def _watch(self, child: _Child) -> bool:
        """Look after one process; false: it is done for good."""
        if child.again_s is not None:
            if time.monotonic() >= child.again_s:
                self._start(child)
            return True
        if child.running is None:
            return False
        code = child.running.poll()
        if code is None:
            return True
        self._reap(child, code, stopping=False)
        return child.again_s is not None

    def _reap(self, child: _Child, code: int, stopping: bool) -> None:
        """Note how a process ended, and whether it is to run again."""
        for thread in child.threads:
            thread.join(timeout=1.0)
        child.threads.clear()
        child.running, child.code = None, code
        self._killed |= code < 0
        name, restart = child.process.name, child.process.restart
        if stopping:
            self._judge_end(name, code)
            return
        if child.process.ends:
            self._stopping.set()
        if restart and code != BAD_CONFIGURATION:
            lasted_s = time.monotonic() - child.began_s
            child.pause_s = _FIRST_PAUSE_S if lasted_s > _HEALTHY_S else child.pause_s
            child.again_s = time.monotonic() + child.pause_s
            self._write(f'[{name}] ended with {code}: starting again in {child.pause_s:g} s')
            child.pause_s = min(2 * child.pause_s, _LONGEST_PAUSE_S)
        elif code != 0:
            self._fail(f'[{name}] failed with {code}')
            if code == BAD_CONFIGURATION:
                self._stopping.set()

    def _judge_end(self, name: str, code: int) -> None:
        """Report a process that did not stop as it should."""
        if code not in (0, -signal.SIGINT, -signal.SIGTERM):
            self._fail(f'[{name}] ended with {code} when asked to stop')

    def _fail(self, line: str) -> None:
        self.failures.append(line)
        self._write(line)


def _signal_group(child: _Child, number: int) -> None:
    """Send a signal to a process; by force also to what it left behind."""
    if child.running is None:
        return
    try:
        if number == signal.SIGKILL:
            os.killpg(child.running.pid, number)
        else:
            child.running.send_signal(number)
    except ProcessLookupError:
        pass


def _wait_all(children: Sequence[_Child], patience_s: float) -> None:
    until = time.monotonic() + patience_s
    while time.monotonic() < until:
        if all(child.running is None or child.running.poll() is not None for child in children):
            return
        time.sleep(_POLL_S)
