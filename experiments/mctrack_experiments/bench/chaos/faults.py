"""The faults, one after another: each is made, looked at from outside, and ended."""

from __future__ import annotations

import math
import os
import resource
import signal
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mctrack_experiments.bench.chaos.graph import RECORDED, LiveGraph
from mctrack_experiments.bench.chaos.scene import DETECTORS, PERIOD_S, Wrong
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagReader, CutBagWarning

_BEHIND = 'north'
"""The detector with which something is wrong."""
_LASTS_S = 3.0
_FLUSHED_S, _LATENCY_S = 0.5, 0.2
"""So much of a recording may be lost when the recorder ends, and so much older than their arrival
are tracks at most, s."""
_ROOM = 8_000
"""Bytes that a disk takes before it is full."""
_REFUSING = Path('/sys')
"""A folder in which nobody can write, whoever he is."""


class Outcome(NamedTuple):
    """
    What came of a fault.

    Attributes
    ----------
    named_s : float
        After how long `/diagnostics` named it, s.
    kept : float
        Share of the people with the same id afterwards.
    pause_s : float
        Longest time without tracks of the people whom the other cameras see, s.
    lost : int
        Recorded messages that are missing, but for what was not flushed yet.
    message : str
        How it was named.

    """

    named_s: float
    kept: float
    pause_s: float
    lost: int = 0
    message: str = ''


def kill(graph: LiveGraph, node: str) -> Outcome:
    """Kill a node with -9; its supervisor starts it again."""
    active = graph.activations(node)

    def is_back() -> bool:
        return graph.activations(node) > active

    return _tried(graph, lambda: graph.kill(node), f'supervisor: {node}', 'ended with -9', is_back)


def silence(graph: LiveGraph) -> Outcome:
    """Let a camera be silent for 3 s."""
    with _wrong(graph, Wrong(is_silent=True)) as begin:
        return _tried(graph, begin, f'fusion: {_BEHIND}', 'no data')


def delay(graph: LiveGraph) -> Outcome:
    """Let what a camera sends come 500 ms late."""
    with _wrong(graph, Wrong(late_s=0.5)) as begin:
        return _tried(graph, begin, f'fusion: {_BEHIND}', ' late')


def loss(graph: LiveGraph) -> Outcome:
    """Lose 5 % of the messages of a camera."""

    def begin() -> None:
        graph.feed.lost_s = math.inf
        graph.feed.wrong[_BEHIND] = Wrong(lost=0.05)
        graph.until(lambda: math.isfinite(graph.feed.lost_s), 'a message is lost')

    try:
        return _tried(graph, begin, f'fusion: {_BEHIND}', ' lost', since=lambda: graph.feed.lost_s)
    finally:
        _mend(graph)


def clock(graph: LiveGraph) -> Outcome:
    """Set a camera's clock back by 1 s."""
    with _wrong(graph, Wrong(ahead_s=-1.0)) as begin:
        return _tried(graph, begin, f'fusion: {_BEHIND} clock', '')


def full_disk(graph: LiveGraph, path: Path) -> Outcome:
    """Let the disk be full while a bag is recorded: no file may grow any more."""
    with graph.recorder(path) as supervisor:
        _recording(graph)
        number = supervisor.pids()['recorder']

        def begin() -> None:
            size = max(each.stat().st_size for each in path.iterdir()) + _ROOM
            resource.prlimit(number, resource.RLIMIT_FSIZE, (size, size))

        def is_over() -> bool:
            return 'recorder' in supervisor.codes()

        found = _tried(graph, begin, 'recorder: node', 'File too large', is_over)
    return _counted(found, graph, path, 0.0, graph.said_s('File too large'))


def killed_recorder(graph: LiveGraph, path: Path) -> Outcome:
    """Kill the recorder with -9."""
    with graph.recorder(path) as supervisor:
        _recording(graph)
        number, killed_s = supervisor.pids()['recorder'], list[float]()

        def begin() -> None:
            killed_s.append(time.monotonic())
            os.kill(number, signal.SIGKILL)

        def is_over() -> bool:
            return 'recorder' in supervisor.codes()

        found = _tried(
            graph,
            begin,
            'recording/supervisor: recorder',
            'ended with -9',
            is_over,
        )
    return _counted(found, graph, path, _FLUSHED_S, killed_s[0])


def read_only_disk(graph: LiveGraph) -> Outcome:
    """Record to a disk that takes nothing."""
    with ExitStack() as stack:

        def begin() -> None:
            supervisor = stack.enter_context(graph.recorder(_REFUSING / 'mctrack_bag'))
            graph.until(lambda: 'recorder' in supervisor.codes(), 'the recorder ends')

        def said_s() -> float:
            return graph.said_s(str(_REFUSING))

        part = 'recording/supervisor: recorder'
        return _tried(graph, begin, part, str(_REFUSING), since=said_s)


def is_there_a_read_only_disk() -> bool:
    """Tell whether there is a folder in which even this process cannot write."""
    try:
        (_REFUSING / 'mctrack_probe').mkdir()
    except OSError:
        return True
    (_REFUSING / 'mctrack_probe').rmdir()
    return False


def shutdown_s(graph: LiveGraph, node: str, number: signal.Signals) -> float:
    """Return how long a process of the graph takes to end after a signal, s; it comes back."""
    process = graph.supervisor.pids()[node]
    active = graph.activations(node)
    began_s = time.monotonic()
    os.kill(process, number)
    graph.until(lambda: graph.supervisor.pids().get(node) != process, f'{node} ends')
    ended_s = time.monotonic() - began_s
    graph.until(lambda: graph.activations(node) > active, f'{node} is active again')
    return ended_s


def _counted(
    found: Outcome, graph: LiveGraph, path: Path, not_flushed_s: float, ended_s: float
) -> Outcome:
    """
    Count what a bag lacks of the tracks that others heard while it was recorded.

    It must hold all up to its last ones, and up to shortly before the recorder's end.
    """
    with warnings.catch_warnings():
        warnings.simplefilter('ignore', CutBagWarning)  # it was cut on purpose
        bag = BagReader(path)
    with bag:
        stamps = {rows.stamp_ns for rows, _ in bag.rows('/tracks', Tracks)}
    heard = [rows.stamp_ns for rows in graph.tracks[:]]
    ago_s = time.monotonic() - ended_s + _FLUSHED_S + _LATENCY_S
    last_ns = max(max(stamps) - round(not_flushed_s * 1e9), time.time_ns() - round(ago_s * 1e9))
    lost = [each for each in heard if min(stamps) <= each <= last_ns and each not in stamps]
    return found._replace(lost=len(lost))


def _recording(graph: LiveGraph) -> None:
    """Wait until a recording has a second of tracks on the disk."""
    begun_s = time.monotonic()

    def is_recording() -> bool:
        said = (one for one in graph.said[:] if one.name == '/recorder: recording')
        return any(
            one.at_s > begun_s and one.values['topics'] == str(len(RECORDED)) for one in said
        )

    graph.until(is_recording, 'all topics are recorded')
    count = len(graph.tracks)
    graph.until(lambda: len(graph.tracks) > count + 1.0 / PERIOD_S, 'a second was recorded')


def _tried(
    graph: LiveGraph,
    begin: Callable[[], None],
    part: str,
    words: str,
    is_over: Callable[[], bool] = lambda: True,
    since: Callable[[], float] | None = None,
) -> Outcome:
    """
    Begin a fault, wait until it is named and has lasted, and see who has which id then.

    Unless it is told since when the fault is there, that is since it was begun.

    """
    before = graph.settled_after(part, words)
    first, began_s = len(graph.tracks), time.monotonic()
    begin()
    fault_s = began_s if since is None else since()
    said = graph.until(lambda: graph.named(fault_s, part, words), f'{part} is named')
    graph.until(lambda: time.monotonic() - began_s > _LASTS_S and is_over(), 'it is over')
    _mend(graph)
    after = graph.settled()
    stamps = np.array([rows.stamp_ns for rows in graph.tracks[max(first - 1, 0) :]])
    kept = sum(after[person] == name for person, name in before.items()) / len(before)
    pause_s = float(np.diff(stamps).max(initial=0)) * 1e-9
    return Outcome(said.at_s - fault_s, kept, pause_s, 0, f'{said.name}: {said.message}')


@contextmanager
def _wrong(graph: LiveGraph, wrong: Wrong) -> Iterator[Callable[[], None]]:
    """Yield what lets something be wrong with one camera; it is mended in the end."""

    def begin() -> None:
        graph.feed.wrong[_BEHIND] = wrong

    try:
        yield begin
    finally:
        _mend(graph)


def _mend(graph: LiveGraph) -> None:
    for name in DETECTORS:
        graph.feed.wrong[name] = Wrong()
