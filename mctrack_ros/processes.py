"""Worker processes: forked from a server that has imported what they need, once for all."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import forkserver
from multiprocessing.context import ForkServerContext

NEEDED = ['__main__', 'mctrack_ros.replay.workers']


def worker_context() -> ForkServerContext:
    """Return where worker processes come from; the server runs from now on."""
    context = multiprocessing.get_context('forkserver')
    context.set_forkserver_preload(NEEDED)
    with _same_modules():
        forkserver.ensure_running()
    return context


def prepare_workers() -> None:
    """Start the server, so that it imports while the caller does."""
    worker_context()


@contextmanager
def _same_modules() -> Iterator[None]:
    """
    Let a Python process that starts meanwhile look for modules where this one does.

    Otherwise the server would look into the current directory first, and run what lies there.

    """
    wanted = {'PYTHONSAFEPATH': '1', 'PYTHONPATH': os.pathsep.join(sys.path)}
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
