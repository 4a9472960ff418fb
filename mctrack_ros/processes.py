"""Worker processes: forked from a server that has imported what they need, once for all."""

from __future__ import annotations

import multiprocessing
from multiprocessing import forkserver
from multiprocessing.context import ForkServerContext

NEEDED = ['__main__', 'mctrack_ros.replay.workers']


def worker_context() -> ForkServerContext:
    """Return where worker processes come from."""
    context = multiprocessing.get_context('forkserver')
    context.set_forkserver_preload(NEEDED)
    return context


def prepare_workers() -> None:
    """Start the server, so that it imports while the caller does."""
    worker_context()
    forkserver.ensure_running()
