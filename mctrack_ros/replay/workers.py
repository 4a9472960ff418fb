"""Processes that step cameras, each waiting only for the feedback its next picture uses."""

from __future__ import annotations

import multiprocessing
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Any

import cv2

from mctrack_ros.config import ConfigError
from mctrack_ros.ground import GridError, ProjectionError
from mctrack_ros.recording import BagError
from mctrack_ros.replay.camera_source import CameraSource, CameraTask

EXPECTED_ERRORS = (BagError, ConfigError, GridError, ProjectionError, ValueError)
"""What bad input raises: told in one line instead of a trace."""


class CameraWorkers:
    """
    Processes among which the cameras are dealt out.

    Parameters
    ----------
    tasks : sequence of CameraTask
        The cameras.
    processes : int
        How many processes.

    """

    def __init__(self, tasks: Sequence[CameraTask], processes: int) -> None:
        context = multiprocessing.get_context('spawn')
        self.connections: list[Connection] = []
        self._processes = []
        for index in range(min(processes, len(tasks))):
            here, there = context.Pipe()
            share = list(tasks[index::processes])
            process = context.Process(target=_work, args=(there, share), daemon=True)
            process.start()
            there.close()
            self.connections.append(here)
            self._processes.append(process)

    def announce(self, tick_index: int, feedback: Sequence[Any]) -> None:
        """Tell all processes the feedback made since, and up to which tick it is complete."""
        for connection in self.connections:
            try:
                connection.send((tick_index, list(feedback)))
            except (BrokenPipeError, ConnectionResetError):
                continue

    def stop(self) -> None:
        """End the processes."""
        for connection in self.connections:
            connection.close()
        for process in self._processes:
            process.terminate()
            process.join()


def _work(connection: Connection, tasks: list[CameraTask]) -> None:
    """Step the cameras of one process in the order of their stamps; say what comes next."""
    cv2.setNumThreads(1)
    try:
        sources = {task.camera: CameraSource(task) for task in tasks}
        for camera, source in sources.items():
            connection.send(('next', camera, source.next_stamp_ns, None))
        complete_to = -1
        while True:
            waiting = [
                (s.next_stamp_ns, c) for c, s in sources.items() if s.next_stamp_ns is not None
            ]
            if not waiting:
                break
            _, camera = min(waiting)
            source = sources[camera]
            while complete_to < source.wanted_tick:
                complete_to, feedback = connection.recv()
                for item in feedback:
                    for each in sources.values():
                        each.push(item)
            result = source.step()
            connection.send(('next', camera, source.next_stamp_ns, result))
        connection.send(('done', '', None, None))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return
    except EXPECTED_ERRORS as error:
        connection.send(('error', '', None, error))
