"""Processes that step cameras, each waiting only for the feedback its next image uses."""

from __future__ import annotations

import gc
import pickle
import resource
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Thread
from typing import Any

import cv2

from mctrack_ros.config import ConfigError
from mctrack_ros.ground import CalibrationError
from mctrack_ros.processes import worker_context
from mctrack_ros.recording import BagError, CutBagWarning
from mctrack_ros.replay.camera_source import CameraResult, CameraSource, CameraTask
from mctrack_ros.replay.quality import CameraQuality

EXPECTED_ERRORS = (BagError, CalibrationError, ConfigError, ValueError)
"""Exceptions of bad input, shown as one line instead of a trace."""


NEVER = 1 << 62
"""Tick of an image that does not come."""


@dataclass(frozen=True, slots=True)
class Progress:
    """
    How far a process is.

    Attributes
    ----------
    next_tick : int
        Index of the tick of its next image; `NEVER`: there is none.
    results : list of CameraResult
        What was made since the last report.
    peak_memory_mb : float
        Largest resident set so far, MB; 0 while it goes on.
    notes, faults : tuple of str
        At the end, what the videos left open and why they are not whole, a line each.
    quality : tuple of CameraQuality
        At the end, what the images of each camera were good for.

    """

    next_tick: int
    results: list[CameraResult]
    peak_memory_mb: float = 0.0
    notes: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    quality: tuple[CameraQuality, ...] = ()


class CameraWorkers:
    """
    Processes among which the cameras are dealt out.

    Parameters
    ----------
    tasks : sequence of CameraTask
        The cameras.
    processes : int
        How many processes.

    Attributes
    ----------
    connections : list of Connection
        To each.
    peak_memory_mb : float
        Largest resident set of those that are done, MB.
    notes, faults : list of str
        What the videos of those left open and why they are not whole, a line each.
    quality : list of CameraQuality
        What the images of those were good for.

    """

    def __init__(self, tasks: Sequence[CameraTask], processes: int) -> None:
        context = worker_context()
        self.connections: list[Connection] = []
        self.peak_memory_mb = 0.0
        self.notes: list[str] = []
        self.faults: list[str] = []
        self.quality: list[CameraQuality] = []
        self._processes = []
        for index in range(min(processes, len(tasks))):
            here, there = context.Pipe()
            share = list(tasks[index::processes])
            process = context.Process(target=_work, args=(there, share), daemon=True)
            process.start()
            there.close()
            self.connections.append(here)
            self._processes.append(process)
        self._outbox: SimpleQueue[bytes | None] = SimpleQueue()
        self._sender = Thread(target=self._send, daemon=True)
        self._sender.start()

    def announce(self, tick_index: int, feedback: Sequence[Any]) -> None:
        """Send all new feedback, by session, and the tick up to which it is complete."""
        self._outbox.put(pickle.dumps((tick_index, list(feedback))))

    def _send(self) -> None:
        """Send what is announced, beside the caller: a process may be sending much itself."""
        while (message := self._outbox.get()) is not None:
            for connection in self.connections:
                try:
                    connection.send_bytes(message)
                except (BrokenPipeError, ConnectionResetError):
                    continue

    def ended(self, last: Progress) -> None:
        """Keep the last report of a process."""
        self.peak_memory_mb = max(self.peak_memory_mb, last.peak_memory_mb)
        self.notes += last.notes
        self.faults += last.faults
        self.quality += last.quality

    def close(self) -> None:
        """End the processes."""
        for process in self._processes:
            process.terminate()
            process.join()
        self._outbox.put(None)
        self._sender.join()
        for connection in self.connections:
            connection.close()


def _work(connection: Connection, tasks: list[CameraTask]) -> None:
    """Step the cameras of one process in the order of their stamps; report tick by tick."""
    cv2.setNumThreads(1)
    warnings.simplefilter('ignore', CutBagWarning)  # the process that began this one has warned
    try:
        sources = {task.camera: CameraSource(task) for task in tasks}
        gc.freeze()  # what is here lives on: the collector need not look at it again
        complete_to, tick = -1, -1
        results: list[CameraResult] = []
        while waiting := [
            (s.session, s.next_stamp_ns, c)
            for c, s in sources.items()
            if s.next_stamp_ns is not None
        ]:
            source = sources[min(waiting)[-1]]
            if source.next_tick != tick:
                tick = source.next_tick
                connection.send(Progress(tick, results))
                results = []
            while complete_to < source.wanted_tick:
                complete_to, feedback = connection.recv()
                for session, item in feedback:
                    for each in sources.values():
                        each.push(item, session)
            results.append(source.step())
        notes = tuple(line for source in sources.values() for line in source.notes())
        faults = tuple(line for source in sources.values() if (line := source.fault()))
        quality = tuple(source.quality for source in sources.values())
        connection.send(Progress(NEVER, results, peak_memory_mb(), notes, faults, quality))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return
    except EXPECTED_ERRORS as error:
        connection.send(error)


def peak_memory_mb() -> float:
    """Return the largest resident set of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
