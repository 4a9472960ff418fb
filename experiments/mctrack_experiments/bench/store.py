"""How fast the trajectory database is, and how large."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from itertools import count
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import text

from mctrack_experiments.postgres_server import missing, postgres_server
from mctrack_ros.cli.sites import named_site
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import REPORTED, Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.track import track_bag
from mctrack_ros.store import Database, NewRun, Run, TrajectoryWriter, crossings, near, occupancy

TRACKS, RATE_HZ = 25, 25
RADIUS_M = 3.0
LINE = [(52.5, 0.0), (52.5, 68.0)]
AREA = [(0.0, 13.84), (16.5, 13.84), (16.5, 54.16), (0.0, 54.16)]
"""The halfway line and a penalty area."""
QUESTIONS = 100
BEGAN_NS = 1_700_000_000_000_000_000
_HOUR_TICKS = 3600 * RATE_HZ
_MONTH_H = 30 * 24
_WHOLE = 'SELECT page_count * page_size FROM pragma_page_count(), pragma_page_size()'
_SHIFT_M = 30.0
"""Tracks are used again that far away where the bag has fewer than are stored."""
_SIZES = {
    'sqlite': (
        'SELECT sum(pgsize) FROM dbstat',
        "SELECT sum(pgsize) FROM dbstat WHERE name = 'rests'",
    ),
    'postgresql': (
        'SELECT sum(pg_total_relation_size(c.oid)) FROM pg_class c JOIN pg_namespace n '
        "ON n.oid = c.relnamespace WHERE c.relkind = 'r' AND n.nspname = 'public' "
        "AND c.relname <> 'spatial_ref_sys'",
        "SELECT pg_total_relation_size('rests')",
    ),
}
"""Bytes of all tables with their indices, and of the second blobs."""


def bench_store(bag: Path, minutes: int = 60, seed: int = 1) -> Figures:
    """
    Store a run of 25 tracks at 25 Hz and ask who was near whom.

    The tracks are those of the joint tracker over a bag of detections, played forwards and
    backwards until the time is full: positions and covariances are a tracker's.

    Parameters
    ----------
    bag : Path
        With detections of five cameras on a pitch.
    minutes : int
        How long the run is.
    seed : int
        Of the questions.

    """
    tape = track_tape(bag)
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, value in _measured(str(Path(folder) / 'tracks.db'), tape, minutes, seed).items():
            figures[f'sqlite.{name}'] = value
    if not missing():
        with postgres_server() as server:
            for name, value in _measured(server.new_database(), tape, minutes, seed).items():
                figures[f'postgres.{name}'] = value
    return Figures(
        'bench_store',
        'mctrack bench store',
        {
            'tracks': TRACKS,
            'rate_hz': RATE_HZ,
            'minutes': minutes,
            'positions': TRACKS * RATE_HZ * 60 * minutes,
            'questions': f'{QUESTIONS} random tracks and minutes, the median counts',
            'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
            'postgres': missing() or 'on a local socket, its settings as shipped',
        },
        figures,
    )


def bench_store_long(bag: Path, hours: int = 24, seed: int = 1) -> Figures:
    """
    Store a day in SQLite and say what a month takes.

    Speed and the time of a question follow the logarithm of the positions, as trees grow by it,
    and the size the positions: lines are fitted to what is measured when the run's length has
    doubled, and drawn on to a month.

    Parameters
    ----------
    bag : Path
        As `bench_store` takes it.
    hours : int
        How long the run is, at least 2.
    seed : int
        Of the questions.

    """
    tape = track_tape(bag)
    marks = [2**k for k in range(hours.bit_length()) if 2**k < hours] + [hours]
    rates, sizes, waits = [], [], []
    with (
        tempfile.TemporaryDirectory() as folder,
        Database(Path(folder) / 'tracks.db', create=True) as database,
        TrajectoryWriter(database, NewRun('bench')) as writer,
    ):
        done = 0
        for mark in marks:
            seconds = _write(writer, tape, range(done * _HOUR_TICKS, mark * _HOUR_TICKS))
            rates.append((mark - done) * _HOUR_TICKS * TRACKS / seconds)
            done = mark
            with database.connected() as connection:
                sizes.append(int(connection.execute(text(_WHOLE)).scalar_one()))
            with Run(database) as run:
                waits.append(_wait_near(run, tape[0].track_id.tolist(), mark * 60, seed))
    growth, doublings = np.array(marks, np.float64), np.log2(marks)

    def month(values: Sequence[float], along: NDArray[np.float64], at: float) -> float:
        slope, begin = np.polyfit(along, values, 1)
        return float(begin + slope * at)

    figures = {
        'positions': hours * _HOUR_TICKS * TRACKS,
        'month.positions': _MONTH_H * _HOUR_TICKS * TRACKS,
        'month.positions_per_s': month(rates, doublings, np.log2(_MONTH_H)),
        'month.gigabytes': month(sizes, growth, _MONTH_H) / 1e9,
        'month.query_ms': month(waits, doublings, np.log2(_MONTH_H)) * 1e3,
        'slope.positions_per_s': float(np.polyfit(doublings, rates, 1)[0]),
        'slope.query_ms': float(np.polyfit(doublings, waits, 1)[0]) * 1e3,
    }
    for index, name in ((0, 'first'), (-1, 'last')):
        figures[f'{name}.positions_per_s'] = rates[index]
        figures[f'{name}.gigabytes'] = sizes[index] / 1e9
        figures[f'{name}.query_ms'] = waits[index] * 1e3
    return Figures(
        'bench_store_long',
        'mctrack bench store --long',
        {
            'tracks': TRACKS,
            'rate_hz': RATE_HZ,
            'hours': ', '.join(map(str, marks)),
            'slope': 'a doubling of the length',
            'questions': f'{QUESTIONS} random tracks and minutes, the median counts',
            'load': f'{os.getloadavg()[0]:.1f} processes wanted the CPUs in the last minute',
        },
        figures,
    )


def track_tape(bag: Path) -> list[Tracks]:
    """Return messages of tracks that all live from the first to the last, forwards and back."""
    with tempfile.TemporaryDirectory() as folder:
        track_bag(bag, folder, named_site('pitch5'), processes=1)
        with BagReader(Path(folder) / 'bag') as reader:
            messages = [rows for rows, _ in reader.rows('/tracks', Tracks)]
    messages = messages[len(messages) // 2 :]
    reported = [rows.select(np.isin(rows.status, REPORTED)) for rows in messages]
    alive = set(reported[0].track_id.tolist())
    for rows in reported:
        alive &= set(rows.track_id.tolist())
    forwards = [_filled(rows.select(np.isin(rows.track_id, list(alive)))) for rows in reported]
    return forwards + forwards[::-1]


def _filled(rows: Tracks) -> Tracks:
    """Return as many tracks as are stored; those that lack are others, moved."""
    parts = []
    for again in count():
        position = rows.position + np.array([again * _SHIFT_M, 0, 0], np.float32)
        parts.append(rows.replace(position=position, track_id=rows.track_id + 1000 * again))
        if (again + 1) * len(rows) >= TRACKS:
            break
    return Tracks.joined(rows.stamp_ns, parts).select(np.arange(TRACKS))


def _measured(place: str, tape: Sequence[Tracks], minutes: int, seed: int) -> dict[str, float]:
    """Return the figures of a database."""
    ticks = minutes * 60 * RATE_HZ
    with Database(place, create=True) as database:
        began = time.perf_counter()
        with TrajectoryWriter(database, NewRun('bench')) as writer:
            _write(writer, tape, range(ticks))
        seconds = time.perf_counter() - began
        whole, rest = _SIZES[database.engine.dialect.name]
        with database.connected() as connection:
            sizes = [int(connection.execute(text(each)).scalar_one()) for each in (whole, rest)]
        positions = ticks * TRACKS
        with Run(database) as run:
            waits = _waits(run, tape[0].track_id.tolist(), minutes, seed)
    return {
        'positions_per_s': positions / seconds,
        'bytes_per_position': (sizes[0] - sizes[1]) / positions,
        'rest_bytes_per_position': sizes[1] / positions,
        **waits,
    }


def _write(writer: TrajectoryWriter, tape: Sequence[Tracks], ticks: range) -> float:
    """Write ticks of a tape that is played again and again; return how long it takes, s."""
    began = time.perf_counter()
    for k in ticks:
        stamp_ns = BEGAN_NS + k * 1_000_000_000 // RATE_HZ
        writer.write_tracks(tape[k % len(tape)].at(stamp_ns))
    writer.flush()
    return time.perf_counter() - began


def _questions(
    tracks: Sequence[int], minutes: int, seed: int
) -> Iterator[tuple[int, tuple[float, float]]]:
    """Yield random tracks, and from when until when, a minute, s."""
    random = np.random.default_rng(seed)
    for _ in range(QUESTIONS):
        track, minute = int(random.choice(tracks)), int(random.integers(minutes))
        yield track, (minute * 60.0, minute * 60.0 + 60.0)


def _wait_near(run: Run, tracks: Sequence[int], minutes: int, seed: int) -> float:
    """Return the median time of the question who was near a track, s."""
    waits = []
    for track, between in _questions(tracks, minutes, seed):
        began = time.perf_counter()
        near(run, track, RADIUS_M, between)
        waits.append(time.perf_counter() - began)
    return float(np.median(waits))


def _waits(run: Run, tracks: Sequence[int], minutes: int, seed: int) -> dict[str, float]:
    """Return how long questions about tracks, points, lines and areas take, ms."""
    of_tracks, of_points, of_lines, of_areas = [], [], [], []
    for track, between in _questions(tracks, minutes, seed):
        began = time.perf_counter()
        visits = near(run, track, RADIUS_M, between)
        of_tracks.append(time.perf_counter() - began)
        x, y = (visits[0].x, visits[0].y) if visits else (0.0, 0.0)
        began = time.perf_counter()
        near(run, (x, y), RADIUS_M, between)
        of_points.append(time.perf_counter() - began)
        began = time.perf_counter()
        crossings(run, LINE, between)
        of_lines.append(time.perf_counter() - began)
        began = time.perf_counter()
        occupancy(run, AREA, between)
        of_areas.append(time.perf_counter() - began)
    began = time.perf_counter()
    crossings(run, LINE)
    of_run = time.perf_counter() - began
    return {
        'query_ms': float(np.median(of_tracks)) * 1e3,
        'query_p99_ms': float(np.quantile(of_tracks, 0.99)) * 1e3,
        'point_query_ms': float(np.median(of_points)) * 1e3,
        'point_query_p99_ms': float(np.quantile(of_points, 0.99)) * 1e3,
        'crossings_ms': float(np.median(of_lines)) * 1e3,
        'occupancy_ms': float(np.median(of_areas)) * 1e3,
        'whole_crossings_s': of_run,
    }
