"""Questions about the tracks of a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from sqlalchemy import select

from mctrack_ros.interfaces import PAUSE_NS, ClassCode, TrackStatus
from mctrack_ros.store.blocks import ID
from mctrack_ros.store.boxes import Box
from mctrack_ros.store.queries.results import Meeting, Place, TrackSummary, Visit
from mctrack_ros.store.queries.run import ALWAYS, Between, Run
from mctrack_ros.store.rows import SPAN_NS, TrackRows, load_journal, load_rows
from mctrack_ros.store.schema import TRACKS

Floats = NDArray[np.float64]

_STEP_NS = 200_000_000
"""Distances add up over steps of this length: shorter ones are the tracker's noise."""
_WINDOW_S = 60.0
"""Of a run, so much is looked at at a time."""


def trajectory(run: Run, track: int, between: Between = ALWAYS) -> list[Place]:
    """Return where a track was, in the order of time."""
    rows = run.rows(between, tracks=[track], whole=True)
    position, velocity = rows.position().tolist(), rows.column('velocity').tolist()
    covariance = rows.column('covariance')
    status = [TrackStatus(code).name.lower() for code in rows.column('status').tolist()]
    variances = covariance[:, [0, 0, 1], [0, 1, 1]].tolist()
    return [
        Place(
            track_id=life,
            reported_id=reported_id,
            time_s=run.seconds(stamp_ns),
            stamp_ns=stamp_ns,
            x=place[0],
            y=place[1],
            vx=speed[0],
            vy=speed[1],
            variance_xx=variance[0],
            variance_xy=variance[1],
            variance_yy=variance[2],
            status=state,
        )
        for life, reported_id, stamp_ns, place, speed, variance, state in zip(
            rows.life.tolist(),
            rows.track_id.tolist(),
            rows.stamp_ns.tolist(),
            position,
            velocity,
            variances,
            status,
        )
    ]


def near(
    run: Run, whom: int | tuple[float, float], radius: float, between: Between = ALWAYS
) -> list[Visit]:
    """Return who was within a distance, m, of a track or of a point x, y."""
    if isinstance(whom, tuple):
        x, y = whom
        bounds = (x - radius, y - radius, x + radius, y + radius)
        rows = run.rows(between, boxes=[run.box(between, bounds)])
        distance = np.hypot(*(rows.position() - [x, y]).T)
        return _visits(run, rows, distance, radius)
    path = run.rows(between, tracks=[whom])
    if not len(path):
        return []
    rows = run.rows(between, boxes=_boxes_along(run, path, radius))
    at = np.minimum(np.searchsorted(path.stamp_ns, rows.stamp_ns), len(path) - 1)
    kept = (path.stamp_ns[at] == rows.stamp_ns) & (rows.life != whom)
    rows, at = rows.select(kept), at[kept]
    distance = np.hypot(*(rows.position() - path.position()[at]).T)
    return _visits(run, rows, distance, radius)


def _boxes_along(run: Run, path: TrackRows, radius: float) -> list[Box]:
    """Return boxes, each of some seconds, around a path and what is near it."""
    span = (path.stamp_ns - run.began_ns) // (2 * SPAN_NS)
    boxes = []
    for part in np.split(np.arange(len(path)), np.flatnonzero(np.diff(span)) + 1):
        place = path.select(part).position()
        (left, low), (right, high) = place.min(axis=0) - radius, place.max(axis=0) + radius
        times = run.seconds(path.stamp_ns[part[0]]), run.seconds(path.stamp_ns[part[-1]])
        boxes.append(run.box(times, (left, low, right, high)))
    return boxes


def meetings(
    run: Run,
    radius: float = 1.5,
    least_s: float = 0.0,
    between: Between = ALWAYS,
    track: int | None = None,
) -> list[Meeting]:
    """
    Return who met whom.

    Parameters
    ----------
    run : Run
        The run.
    radius : float
        Who is closer meets, m.
    least_s : float
        Shorter meetings are left out, s.
    between : (float, float)
        From when until before when, s.
    track : int, optional
        Only meetings of this one.

    """
    pairs = [_pairs(rows, radius, track) for rows in windows(run, between)]
    if not pairs:
        return []
    stamp_ns, first, second, distance, place = (np.concatenate(part) for part in zip(*pairs))
    found = []
    for part in episodes(stamp_ns, first, second):
        began_s, ended_s = run.seconds(stamp_ns[part[0]]), run.seconds(stamp_ns[part[-1]])
        if ended_s - began_s < least_s:
            continue
        best = part[np.argmin(distance[part])]
        ids, closest_s = (int(first[best]), int(second[best])), run.seconds(stamp_ns[best])
        closest = float(distance[best])
        found.append(Meeting(*ids, began_s, ended_s, closest, closest_s, *place[best].tolist()))
    return sorted(found, key=lambda each: each.began_s)


def track_ids(run: Run) -> list[int]:
    """Return all ids that are in a run, ascending; some of them may be of nobody any more."""
    asked = select(TRACKS.c.track_id).where(TRACKS.c.run_id == run.stored.run)
    with run.database.connected() as connection:
        found = set(connection.execute(asked).scalars())
        for block in load_journal(connection, run.stored):
            found.update(block.words[:, ID].tolist())
    return sorted(found)


def called_now(run: Run, track: int) -> list[int]:
    """Return whom the rows under an id are taken for; empty: there are no such rows."""
    with run.database.connected() as connection:
        rows = load_rows(connection, run.stored, run.between_ns(ALWAYS), tracks={track}).reported()
        lives = run.identities(connection).lives(rows.track_id, rows.stamp_ns)
    own = run.rows(tracks=[track]).life
    return sorted({*lives.tolist(), *own.tolist()})


def summaries(run: Run, between: Between = ALWAYS, track: int | None = None) -> list[TrackSummary]:
    """Return when each track was there, how far it went and how fast."""
    rows = run.rows(between, tracks=None if track is None else [track], whole=True)
    return [summary_of(run, rows.select(part)) for part in _by_life(rows)]


def summary_of(run: Run, rows: TrackRows) -> TrackSummary:
    """Return the summary of one track's rows, at least one, with all columns."""
    position, classes = rows.position(), rows.column('class_id')
    step = (rows.stamp_ns - rows.stamp_ns[0]) // _STEP_NS
    kept = np.concatenate([[True], np.diff(step) > 0])
    kept[-1] = True
    times = np.diff(rows.stamp_ns[kept])
    length = np.hypot(*np.diff(position[kept], axis=0).T)
    walked = times <= PAUSE_NS
    seconds, distance = float(times[walked].sum()) * 1e-9, float(length[walked].sum())
    long = walked & (times >= _STEP_NS // 2)
    known = classes[classes != 0]
    return TrackSummary(
        int(rows.life[0]),
        ClassCode(known[-1] if len(known) else 0).name.lower(),
        run.seconds(rows.stamp_ns[0]),
        run.seconds(rows.stamp_ns[-1]),
        distance,
        distance / seconds if seconds else 0.0,
        float((length[long] / (times[long] * 1e-9)).max(initial=0.0)),
    )


def _visits(run: Run, rows: TrackRows, distance: Floats, radius: float) -> list[Visit]:
    inside = np.flatnonzero(distance <= radius)
    stamp_ns, life, position = rows.stamp_ns, rows.life, rows.position()
    found = []
    for part in episodes(stamp_ns[inside], life[inside], life[inside]):
        each = inside[part]
        best = each[np.argmin(distance[each])]
        began_s, ended_s = run.seconds(stamp_ns[each[0]]), run.seconds(stamp_ns[each[-1]])
        closest_m, closest_s = float(distance[best]), run.seconds(stamp_ns[best])
        x, y = position[best].tolist()
        found.append(Visit(int(life[best]), began_s, ended_s, closest_m, closest_s, x, y))
    return sorted(found, key=lambda each: each.began_s)


def windows(run: Run, between: Between, *, whole: bool = False) -> Iterator[TrackRows]:
    """Yield the rows of the run a minute at a time, with all columns, or places alone."""
    first, last = between
    ended_s = run.length_s()
    began_s = max(first, 0.0)
    while began_s < min(last, ended_s):
        until_s = min(began_s + _WINDOW_S, last)
        yield run.rows((began_s, until_s), whole=whole)
        began_s = until_s


def _pairs(
    rows: TrackRows, radius: float, track: int | None
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], Floats, Floats]:
    """Return stamps, ids, distances and middles of the pairs that are near each other."""
    _, tick = np.unique(rows.stamp_ns, return_inverse=True)
    position = rows.position()
    # ticks lie so far apart that only rows of the same one are near
    tree = cKDTree(np.column_stack([position, tick * (2 * radius + 1.0)]))
    pairs = tree.query_pairs(radius, output_type='ndarray')
    life = rows.life[pairs]
    pairs = np.where((life[:, 0] > life[:, 1])[:, None], pairs[:, ::-1], pairs)
    if track is not None:
        pairs = pairs[(rows.life[pairs] == track).any(axis=1)]
    pairs = pairs[np.argsort(rows.stamp_ns[pairs[:, 0]], kind='stable')]
    one, other = pairs.T
    distance = np.hypot(*(position[one] - position[other]).T)
    middle = (position[one] + position[other]) / 2
    return rows.stamp_ns[one], rows.life[one], rows.life[other], distance, middle


def _by_life(rows: TrackRows) -> Iterator[NDArray[np.intp]]:
    """Yield the rows of each life, in the order of time."""
    order = np.argsort(rows.life, kind='stable')
    if len(order):
        yield from np.split(order, np.flatnonzero(np.diff(rows.life[order])) + 1)


def episodes(
    stamp_ns: NDArray[np.int64], first: NDArray[np.int64], second: NDArray[np.int64]
) -> Iterator[NDArray[np.intp]]:
    """Yield the rows of each pair of ids, without longer pauses."""
    order = np.lexsort([stamp_ns, second, first])
    if not len(order):
        return
    new = (np.diff(first[order]) != 0) | (np.diff(second[order]) != 0)
    new |= np.diff(stamp_ns[order]) > PAUSE_NS
    yield from np.split(order, np.flatnonzero(new) + 1)
