"""Worker processes: where they are forked from, and when they end."""

from __future__ import annotations

import multiprocessing
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import forkserver
from multiprocessing.context import ForkServerContext
from multiprocessing.process import BaseProcess

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


def end_with_parent() -> None:
    """Let this process end when the one that started it does, even if that was killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)


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
