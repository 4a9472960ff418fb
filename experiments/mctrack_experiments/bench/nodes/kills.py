"""What is lost when the store, its database or the fusion node is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import func, select

from mctrack_experiments.bench.nodes.kills_feed import PERIOD_S, TRACKS
from mctrack_experiments.postgres_server import missing, postgres_server
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ros.graph.graph import ENVIRONMENT, NodeSpec
from mctrack_ros.ros.graph.shared_memory import remove_leftovers
from mctrack_ros.store import Database, StoreError, check
from mctrack_ros.store.rows import unpack_ticks
from mctrack_ros.store.schema import EVENT_MESSAGES, JOURNAL, RUNS, TICKS

PAUSE_S = (0.3, 3.0)
"""Between two kills, since all runs again."""
_PATIENCE_S = 60.0
_FRESH_S = 1.5
"""What is stored is of now if its last stamp is so old at most."""


def bench_kills(kills: int = 50, seed: int = 1, domain: int | None = None) -> Figures:
    """
    Kill the store node, PostgreSQL and the fusion node at random moments, one after the other.

    Parameters
    ----------
    kills : int
        Of each.
    seed : int
        Of the moments.
    domain : int, optional
        ROS domain; unless given, that of the environment.

    """
    environment = dict(ENVIRONMENT) | {'PYTHONUNBUFFERED': '1'}
    environment |= {} if domain is None else {'ROS_DOMAIN_ID': str(domain)}
    figures: dict[str, float] = {}
    for name, measure in (('store', _store), ('database', _database), ('fusion', _fusion)):
        if name == 'database' and missing():
            continue
        random = np.random.default_rng([seed, len(name)])
        with tempfile.TemporaryDirectory(prefix='mctrack-kills-') as folder:
            found = measure(_Graph(Path(folder), environment), kills, random)
        figures |= {f'{name}.{each}': value for each, value in found.items()}
    return Figures(
        'bench_kills',
        'mctrack bench kills',
        {
            'tracks': TRACKS,
            'rate_hz': round(1 / PERIOD_S),
            'kills': f'{kills} of each by SIGKILL',
            'moments': f'{PAUSE_S[0]:g} to {PAUSE_S[1]:g} s after all ran again, seed {seed}',
            'store, fusion': 'into SQLite',
            'database': missing() or 'PostgreSQL, all its processes, away for 0 to 3 s more',
        },
        figures,
    )


@dataclass(slots=True)
class _Graph:
    """Processes of a measurement, in a folder of its own."""

    folder: Path
    environment: Mapping[str, str]
    running: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)

    def node(self, executable: str, **parameters: Any) -> None:
        """Start a node."""
        command = NodeSpec(executable, executable, parameters).process(self.folder).command
        self.start(executable, command)

    def start(self, name: str, command: Sequence[str]) -> None:
        """Start a process; what it says goes into a file."""
        with (self.folder / f'{name}.log').open('ab') as log:
            self.running[name] = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env={**os.environ, **self.environment},
            )

    def feed(self, *words: str) -> None:
        """Start what publishes tracks, or detections, and takes down what was sent and heard."""
        module = 'mctrack_experiments.bench.nodes.kills_feed'
        self.start('feed', [sys.executable, '-m', module, str(self.folder / 'feed.txt'), *words])

    def kill(self, name: str) -> int:
        """Kill a process; return when, ns."""
        process = self.running.pop(name)
        process.kill()
        process.wait()
        killed_ns = time.time_ns()
        remove_leftovers()
        return killed_ns

    def end(self, name: str) -> None:
        """End a process in good order."""
        process = self.running.pop(name)
        process.terminate()
        if process.wait(_PATIENCE_S) not in {0, -signal.SIGTERM}:
            said = (self.folder / f'{name}.log').read_text()
            raise RuntimeError(f'{name} failed: {said}')

    def fed(self, kind: str) -> list[int]:
        """Return the stamps of what was sent or heard, ns."""
        lines = (self.folder / 'feed.txt').read_text().splitlines()
        return [int(line.split()[1]) for line in lines if line.split()[0] == kind]

    def close(self) -> None:
        """Kill what still runs."""
        for name in list(self.running):
            self.kill(name)


@contextmanager
def _closing(graph: _Graph) -> Iterator[None]:
    try:
        yield
    finally:
        graph.close()


def _store(graph: _Graph, kills: int, random: np.random.Generator) -> dict[str, float]:
    """Kill the store node."""
    place = str(graph.folder / 'tracks.db')
    faults, lost, away = 0, [], []
    with _closing(graph):
        graph.feed('tracks')
        graph.node('store_node', database=place)
        _wait(place, 0)
        began_ns = _stamps(place)[0]
        heard_ns = began_ns
        for _ in range(kills):
            time.sleep(random.uniform(*PAUSE_S))
            killed_ns = graph.kill('store_node')
            graph.node('store_node', database=place)
            faults += _faults(place)
            _wait(place, killed_ns)
            sent, stored = graph.fed('tracks'), set(_stamps(place))
            before = [each for each in sent if heard_ns <= each < killed_ns]
            lost.append(sum(each not in stored for each in before))
            heard_ns = min(each for each in stored if each > killed_ns)
            away.append((heard_ns - killed_ns) / 1e9)
        graph.end('store_node')
        ended_ns = _stamps(place)[-1]
        last = [each for each in graph.fed('tracks') if heard_ns <= each <= ended_ns]
        holes = len(set(last) - set(_stamps(place)))
        faults += _faults(place)
        runs = _runs(place)
    return {
        'kills': kills,
        'faults': faults,
        'missing_s': max(lost) * PERIOD_S,
        'missing_mean_s': float(np.mean(lost)) * PERIOD_S,
        'missing_later': holes,
        'runs': runs,
        'away_s': float(np.median(away)),
    }


def _database(graph: _Graph, kills: int, random: np.random.Generator) -> dict[str, float]:
    """Kill PostgreSQL."""
    faults, caught_up = 0, []
    with postgres_server() as server, _closing(graph):
        place = server.new_database()
        graph.feed('tracks')
        spool = str(graph.folder / 'spool')
        graph.node('store_node', database=place, spool=spool)
        _wait(place, 0)
        for _ in range(kills):
            time.sleep(random.uniform(*PAUSE_S))
            server.kill()
            time.sleep(random.uniform(0.0, 3.0))
            server.start()
            began_s = time.monotonic()
            faults += _faults(place)
            _wait(place, time.time_ns())
            caught_up.append(time.monotonic() - began_s)
        graph.end('store_node')
        faults += _faults(place)
        stored = _stamps(place)
        sent = [each for each in graph.fed('tracks') if stored[0] <= each <= stored[-1]]
        events = [each for each in graph.fed('events') if stored[0] <= each < stored[-1]]
        absent = len(set(sent) - set(stored)) + len(set(events) - set(_events(place)))
        runs = _runs(place)
    return {
        'kills': kills,
        'faults': faults,
        'missing_s': absent * PERIOD_S,
        'stored_twice': len(stored) - len(set(stored)),
        'runs': runs,
        'caught_up_s': max(caught_up),
    }


def _fusion(graph: _Graph, kills: int, random: np.random.Generator) -> dict[str, float]:
    """Kill the fusion node."""
    place = str(graph.folder / 'tracks.db')
    settings = {'cameras': ['cam1'], 'state_file': str(graph.folder / 'ids.json')}
    faults, killed = 0, [0]
    with _closing(graph):
        graph.node('store_node', database=place, cameras=['cam1'])
        graph.feed('detections')
        graph.node('fusion_node', **settings)
        _wait(place, 0)
        for _ in range(kills):
            time.sleep(random.uniform(*PAUSE_S))
            killed.append(graph.kill('fusion_node'))
            graph.node('fusion_node', **settings)
            faults += _faults(place)
            _wait(place, killed[-1])
        graph.end('fusion_node')
        time.sleep(1.0)
        graph.end('store_node')
        faults += _faults(place)
        stored, heard = _stamps(place), graph.fed('heard')
        runs = _runs(place)
    absent, connecting = [], []
    for began_ns, ended_ns in pairwise([*killed, time.time_ns()]):
        first_ns = next(each for each in stored if each > began_ns)
        of_run = {each for each in heard if began_ns < each <= ended_ns}
        absent.append(len({each for each in of_run if each >= first_ns} - set(stored)))
        connecting.append(len({each for each in of_run if each < first_ns}))
    return {
        'kills': kills,
        'faults': faults,
        'missing_s': max(absent) * PERIOD_S,
        'connecting_s': max(connecting[1:]) * PERIOD_S,
        'runs': runs,
    }


def _wait(place: str, after_ns: int) -> None:
    """Wait until what is stored is of now, and of after an instant."""
    until_s = time.monotonic() + _PATIENCE_S
    while time.monotonic() < until_s:
        with suppress(StoreError), Database(place) as database:
            while time.monotonic() < until_s:
                if _last(database) > max(after_ns, time.time_ns() - _FRESH_S * 1e9):
                    return
                time.sleep(0.1)
        time.sleep(0.1)
    raise RuntimeError(f'nothing new came into {place} for {_PATIENCE_S:g} s')


def _last(database: Database) -> int:
    """Return the last stamp that is journaled, ns."""
    with database.connected() as connection:
        asked = select(JOURNAL.c.ticks).order_by(JOURNAL.c.run_id.desc(), JOURNAL.c.number.desc())
        found = connection.execute(asked.limit(1)).scalar()
    return 0 if found is None else int(unpack_ticks(found)[-1, 0])


def _faults(place: str) -> int:
    """Open a database and check it; return how much is wrong."""
    with Database(place) as database:
        found = check(database)
    for line in found:
        print(line, file=sys.stderr)
    return len(found)


def _stamps(place: str) -> list[int]:
    """Return the stamps of all ticks in a database, ns."""
    with Database(place) as database, database.snapshot() as connection:
        found = [
            row.ticks
            for table, key in ((TICKS, TICKS.c.span), (JOURNAL, JOURNAL.c.number))
            for row in connection.execute(select(table).order_by(table.c.run_id, key))
        ]
    return sorted(stamp for ticks in found for stamp in unpack_ticks(ticks)[:, 0].tolist())


def _events(place: str) -> list[int]:
    with Database(place) as database, database.connected() as connection:
        return list(connection.execute(select(EVENT_MESSAGES.c.stamp_ns)).scalars())


def _runs(place: str) -> int:
    with Database(place) as database, database.connected() as connection:
        return int(connection.execute(select(func.count()).select_from(RUNS)).scalar_one())
