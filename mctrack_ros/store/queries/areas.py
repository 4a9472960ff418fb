"""Questions about places: events in an area, counts through a line or in an area, heat maps."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from sqlalchemy import select

from mctrack_ros.interfaces import PAUSE_NS, ZONE_EVENTS, EventCode
from mctrack_ros.store.queries.results import Cell, Crossings, Event, Occupancy
from mctrack_ros.store.queries.run import ALWAYS, Between, Run
from mctrack_ros.store.rows import TrackRows
from mctrack_ros.store.schema import EVENTS
from mctrack_ros.store.writer import EVENTS_TOPIC, events_of
from mctrack_ros.zones.paths import NEVER_NS, Paths, passages, stays
from mctrack_ros.zones.shapes import Line, Zone

Points = Sequence[tuple[float, float]]
Ints = NDArray[np.int64]

_STRIDE_M = 2.0
"""Longest way from one tick to the next."""
_LOOK_BACK_S = 60.0
"""Longest time that somebody stands on a line before a question begins, or a window."""
_MOST_PERIODS = 1_000_000
_WINDOW_S = 600.0
"""Crossings and stays are looked for in so much at a time."""


def events(
    run: Run,
    kinds: Collection[EventCode] = (),
    area: Points = (),
    between: Between = ALWAYS,
    track: int | None = None,
) -> list[Event]:
    """
    Return fusion's events.

    Parameters
    ----------
    run : Run
        The run.
    kinds : collection of EventCode
        Only of these kinds; none: of all.
    area : sequence of (float, float)
        Only in this polygon, its corners in m; none: everywhere, also where the place is unknown.
    between : (float, float)
        From when until before when, s.
    track : int, optional
        Only those that concern this one.

    """
    first_ns, last_ns = run.between_ns(between)
    asked = select(EVENTS.c.stamp_ns, EVENTS.c.row).where(
        EVENTS.c.run_id == run.stored.run,
        EVENTS.c.topic == EVENTS_TOPIC,
        EVENTS.c.stamp_ns >= first_ns,
        EVENTS.c.stamp_ns < last_ns,
    )
    if kinds:
        asked = asked.where(EVENTS.c.event.in_(sorted(map(int, kinds))))
    if area:
        left, low, right, high = _polygon(area).bounds
        asked = asked.where(EVENTS.c.x.between(left, right), EVENTS.c.y.between(low, high))
    ordered = asked.order_by(EVENTS.c.stamp_ns, EVENTS.c.number, EVENTS.c.line)
    found = []
    names = ['', *run.zones().names]
    with run.database.connected() as connection:
        identities = run.identities(connection)
        for stamp_ns, row in connection.execute(ordered).all():
            rows = events_of(stamp_ns, [row])
            reported = np.concatenate([rows.track_id, *rows.others, *rows.other_tracks])
            reported = reported.astype(np.int64)
            lives = identities.lives(reported, np.full(len(reported), stamp_ns)).tolist()
            x, y, _ = rows.position[0].tolist()
            if area and not shapely.covers(_polygon(area), shapely.Point(x, y)):
                continue
            ids, code = (int(rows.old_id[0]), int(rows.new_id[0])), EventCode(rows.event[0])
            named = set(lives) if code in ZONE_EVENTS else {*lives, *ids}
            if track is not None and track not in named:
                continue
            zone = int(rows.zone[0])
            is_placed = bool(np.isfinite([x, y]).all())
            found.append(
                Event(
                    code.name.lower(),
                    run.seconds(stamp_ns),
                    stamp_ns,
                    lives[0],
                    int(reported[0]),
                    *ids,
                    tuple(dict.fromkeys(each for each in lives[1:] if each)),
                    float(rows.probability[0]),
                    x if is_placed else None,
                    y if is_placed else None,
                    names[zone] if zone < len(names) else str(zone),
                )
            )
    return found


def crossings(
    run: Run, line: Points | Line, between: Between = ALWAYS, per_s: float = 60.0
) -> list[Crossings]:
    """
    Count who crosses a line, per period, as the zone events of a site do: jitter does not count.

    Parameters
    ----------
    run : Run
        The run.
    line : Line or sequence of (float, float)
        The line, or its points, m; left and right are those of somebody who walks along it.
    between : (float, float)
        From when until before when, s.
    per_s : float
        Length of a period, s.

    """
    if not isinstance(line, Line):
        line = Line('', tuple(line))
    if len(line.points) < 2:
        raise ValueError('a line needs two points')
    points = np.array(line.points, np.float64)
    low, high = points.min(axis=0) - _STRIDE_M, points.max(axis=0) + _STRIDE_M
    bounds = (*low.tolist(), *high.tolist())
    counts: dict[int, list[int]] = defaultdict(lambda: [0, 0])
    for window in _windows(run, between):
        found = passages(line, _paths(run, window, bounds))
        for stamp_ns, way in zip(found.stamp_ns.tolist(), found.way.tolist()):
            if stamp_ns >= run.ns(window[0]):
                counts[_period(run, stamp_ns, per_s)][0 if way > 0 else 1] += 1
    return [
        Crossings(period * per_s, *counts.get(period, (0, 0)))
        for period in _periods(run, between, per_s)
    ]


def occupancy(
    run: Run, area: Points | Zone, between: Between = ALWAYS, per_s: float = 60.0
) -> list[Occupancy]:
    """
    Count who is in an area, per period, as the zone events of a site do: jitter does not count.

    Parameters
    ----------
    run : Run
        The run.
    area : Zone or sequence of (float, float)
        The zone, or the corners of the polygon, m.
    between : (float, float)
        From when until before when, s.
    per_s : float
        Length of a period, s.

    """
    if not isinstance(area, Zone):
        area = Zone('', tuple(area))
    life, entered, left, has_left = _stays(run, area, between)
    answers = []
    for each in _periods(run, between, per_s):
        begin, end = each * per_s, (each + 1) * per_s
        here = (entered < end) & (left > begin)
        seconds = np.clip(left[here], begin, end) - np.clip(entered[here], begin, end)
        answers.append(
            Occupancy(
                begin,
                len(np.unique(life[here])),
                float(seconds.sum()) / per_s,
                _most(np.maximum(entered[here], begin), left[here]),
                int(((entered >= begin) & (entered < end)).sum()),
                int((has_left & (left >= begin) & (left < end)).sum()),
            )
        )
    return answers


def heat_map(
    run: Run,
    cell_m: float = 1.0,
    between: Between = ALWAYS,
    area: Points = (),
    track: int | None = None,
) -> list[Cell]:
    """Return how long somebody was in each square of the ground, where anybody was."""
    boxes = [run.box(between, _polygon(area).bounds)] if area else None
    if track is not None:
        rows = run.rows(between, tracks=[track])
    else:
        rows = run.rows(between, boxes=boxes)
    if area:
        rows = rows.select(_inside(_polygon(area), rows))
    cells, seconds = time_in_cells(rows, cell_m)
    middles = (cells + 0.5) * cell_m
    return [Cell(x, y, time) for (x, y), time in zip(middles.tolist(), seconds.tolist())]


def time_in_cells(rows: TrackRows, cell_m: float) -> tuple[Ints, NDArray[np.float64]]:
    """Return the squares, (m, 2) whole sides from the origin, and the time in each, (m,) s."""
    cells, which = np.unique(
        np.floor(rows.position() / cell_m).astype(np.int64), axis=0, return_inverse=True
    )
    seconds = np.bincount(which.ravel(), _seconds(rows), len(cells)).astype(np.float64)
    return cells, seconds


def _polygon(area: Points) -> shapely.Polygon:
    if len(area) < 3:
        raise ValueError('an area needs three corners')
    polygon = shapely.Polygon(area)
    if not polygon.is_valid:
        raise ValueError('the sides of the area cross one another')
    shapely.prepare(polygon)
    return polygon


def _inside(polygon: shapely.Polygon, rows: TrackRows) -> NDArray[np.bool_]:
    return np.asarray(shapely.intersects_xy(polygon, *rows.position().T), np.bool_)


def _stays(
    run: Run, zone: Zone, between: Between
) -> tuple[Ints, NDArray[np.floating], NDArray[np.floating], NDArray[np.bool_]]:
    """Return who is in a zone, from when to when, s, and whether he has left it by the end."""
    bounds = _polygon(zone.corners).bounds
    over: list[tuple[int, int, int]] = []
    inside: dict[int, int] = {}
    ended_ns = run.began_ns
    for window in _windows(run, between):
        began_ns, ticks_ns = run.ns(window[0]), run.stamps(_earlier(window))
        found = stays(zone, _paths(run, window, bounds), ticks_ns)
        before, inside = inside, {}
        for life, entered_ns, left_ns in zip(
            found.life.tolist(), found.entered_ns.tolist(), found.left_ns.tolist()
        ):
            if left_ns < began_ns:
                continue  # the window before has told it
            if entered_ns < began_ns:
                entered_ns = before.pop(life, entered_ns)
            if left_ns == NEVER_NS:
                inside[life] = entered_ns
            else:
                over.append((life, entered_ns, left_ns))
        over += [(life, entered_ns, began_ns) for life, entered_ns in before.items()]
        ended_ns = int(ticks_ns.max(initial=ended_ns)) + 1
    found_all = over + [(life, entered_ns, ended_ns) for life, entered_ns in inside.items()]
    columns = np.array(found_all, np.int64).reshape(-1, 3).T
    entered, left = (columns[1:] - run.began_ns) / 1e9
    return columns[0], entered, left, np.arange(len(left)) < len(over)


def _windows(run: Run, between: Between) -> Iterator[Between]:
    """Yield the times of a question that are answered at once: a day would fill the memory."""
    begin, end = max(between[0], 0.0), min(between[1], run.length_s())
    while begin < end:
        yield begin, min(begin + _WINDOW_S, end)
        begin += _WINDOW_S


def _paths(run: Run, between: Between, bounds: tuple[float, float, float, float]) -> Paths:
    """Return the whole paths of those who may come within bounds, m."""
    between = _earlier(between)
    near = run.rows(between, boxes=[run.box(between, bounds)])
    rows = run.rows(between, tracks=np.unique(near.life).tolist())
    covariance = rows.column('covariance')[:, :2, :2].astype(np.float64)
    return Paths(rows.life, rows.stamp_ns, rows.position(), covariance)


def _earlier(between: Between) -> Between:
    """Return a time with what comes before: who is on the edge then comes from somewhere."""
    return between[0] - _LOOK_BACK_S, between[1]


def _most(entered: NDArray[np.floating], left: NDArray[np.floating]) -> int:
    """Return how many are inside at most at once."""
    times, change = np.concatenate([entered, left]), np.repeat([1, -1], [len(entered), len(left)])
    times, which = np.unique(times, return_inverse=True)
    return int(np.cumsum(np.bincount(which, change)).max(initial=0))


def _steps(rows: TrackRows) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return first and second row of each step that a life takes."""
    order = np.argsort(rows.life, kind='stable')
    start, end = order[:-1], order[1:]
    is_step = (rows.life[start] == rows.life[end]) & (
        rows.stamp_ns[end] - rows.stamp_ns[start] <= PAUSE_NS
    )
    return start[is_step], end[is_step]


def _seconds(rows: TrackRows) -> NDArray[np.float64]:
    """Return how long each row stands for: until the next one of the same life, s."""
    start, end = _steps(rows)
    seconds = np.zeros(len(rows))
    seconds[start] = (rows.stamp_ns[end] - rows.stamp_ns[start]) * 1e-9
    return seconds


def _period(run: Run, stamp_ns: int, per_s: float) -> int:
    return int(run.seconds(stamp_ns) // per_s)


def _periods(run: Run, between: Between, per_s: float) -> range:
    """Return the periods of a time that the run knows."""
    if per_s <= 0:
        raise ValueError(f'a period of {per_s} s is none')
    first, last = max(between[0], 0.0), min(between[1], run.length_s())
    periods = range(int(first // per_s), int(-(-last // per_s)))
    if len(periods) > _MOST_PERIODS:
        raise ValueError(f'{len(periods)} periods of {per_s:g} s: ask for longer ones')
    return periods
