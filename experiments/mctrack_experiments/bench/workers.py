"""Fresh processes without threads of their own, so that one measurement has one core."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from mctrack_ros.processes import end_with_parent

Job = TypeVar('Job')
Outcome = TypeVar('Outcome')
Progress = Callable[[int, int], None]

THREADS = ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS')


def silent(done: int, total: int) -> None:
    """Show no progress."""


def run_pinned(
    work: Callable[[Job], Outcome], jobs: Sequence[Job], progress: Progress = silent
) -> list[Outcome]:
    """Run jobs one after the other in one process that stays on one core."""
    return _run(work, jobs, progress, 1, _pin)


def run_spread(
    work: Callable[[Job], Outcome], jobs: Sequence[Job], progress: Progress = silent
) -> list[Outcome]:
    """Run jobs in as many processes as there are cores; the outcomes are in the jobs' order."""
    count = min(len(os.sched_getaffinity(0)), max(len(jobs), 1))
    return _run(work, jobs, progress, count, end_with_parent)


def _run(
    work: Callable[[Job], Outcome],
    jobs: Sequence[Job],
    progress: Progress,
    count: int,
    begin: Callable[[], None],
) -> list[Outcome]:
    context = multiprocessing.get_context('spawn')
    with _one_thread(), ProcessPoolExecutor(count, context, begin) as pool:
        outcomes = []
        progress(0, len(jobs))
        for outcome in pool.map(work, jobs):
            outcomes.append(outcome)
            progress(len(outcomes), len(jobs))
        return outcomes


def _pin() -> None:
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    end_with_parent()


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let processes that start meanwhile have no threads for linear algebra."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, '1'))
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value
