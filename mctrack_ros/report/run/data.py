"""What is told of a run: tracks, how many, where, and how good the data are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground.coverage.coverage import Coverage, area_from
from mctrack_ros.interfaces import PAUSE_NS, Ticks
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.tables.columns import ABSOLUTE_NS
from mctrack_ros.report.dropped import COUNTS, drops_of
from mctrack_ros.site.coverage import site_coverage
from mctrack_ros.site.site import SiteConfig
from mctrack_ros.store import Run, events
from mctrack_ros.store.queries.areas import time_in_cells
from mctrack_ros.store.queries.identities import corrections, groups
from mctrack_ros.store.queries.results import Correction, Event, Group, TrackSummary
from mctrack_ros.store.queries.run import Between
from mctrack_ros.store.queries.tracks import summary_of, track_ids
from mctrack_ros.store.rows import TrackRows

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CELL_M = 0.5
"""Side of the squares in which time is counted."""
_GAP = 1.5
"""Gap, in usual ones, from which ticks are missing."""
_WARNING = 1
"""Level of a status from which something is wrong."""


@dataclass(frozen=True, slots=True)
class TrackData:
    """
    A track.

    Attributes
    ----------
    summary : TrackSummary
        When, how far, how fast.
    spells : tuple of (float, float)
        When it was there without a longer pause, s.
    seconds : float
        How long it was there altogether, s.
    cells : (m, 2) int64 array
        Squares of `CELL_M` in which it was, in the coordinates of the site's files.
    times : (m,) float64 array
        How long, s.

    """

    summary: TrackSummary
    spells: tuple[tuple[float, float], ...]
    seconds: float
    cells: Ints
    times: Floats


@dataclass(frozen=True, slots=True)
class CameraQuality:
    """A camera's counts by name in `COUNTS`, and the share of ticks in which it was silent."""

    name: str
    counts: dict[str, int]
    silent: float


@dataclass(frozen=True, slots=True)
class Trouble:
    """What `/diagnostics` said was wrong: of what, what, how many times, and when first, s."""

    part: str
    message: str
    count: int
    first_s: float


@dataclass(frozen=True, slots=True)
class Quality:
    """
    How good the data are.

    Attributes
    ----------
    ticks, missing : int
        Ticks that are there, and that are missing in between.
    interval_s : float
        Usual time between ticks, s.
    gaps : tuple of (float, float)
        When no ticks came, s, the longest first.
    error_m : (n,) float64 array
        Stated standard deviation of positions along their worst direction, quantiles, m.
    cameras : tuple of CameraQuality
        Of a bag with `/ticks`; else empty.
    troubles : tuple of Trouble
        Of a bag with `/diagnostics`, the most frequent first; else empty.

    """

    ticks: int
    missing: int
    interval_s: float
    gaps: tuple[tuple[float, float], ...]
    error_m: Floats
    cameras: tuple[CameraQuality, ...] = ()
    troubles: tuple[Trouble, ...] = ()


@dataclass(frozen=True, slots=True)
class RunData:
    """
    A run.

    Attributes
    ----------
    title, run, site : str
        What it is called.
    began : str
        When, in UTC; empty: its stamps do not count from 1970.
    between : (float, float)
        What is told of it, s.
    tracks : tuple of TrackData
        Those that were there for longest first.
    present : (m,) int64 array
        How many were there at each of ``times``.
    times : (m,) float64 array
        Of all ticks, s.
    events, corrections, groups : tuple
        What happened.
    quality : Quality
        How good the data are.
    coverage : Coverage, optional
        What the site's cameras see.
    area : (n, 2) float64 array, optional
        Corners of the site's area, m.

    """

    title: str
    run: str
    site: str
    began: str
    between: Between
    tracks: tuple[TrackData, ...]
    present: Ints
    times: Floats
    events: tuple[Event, ...]
    corrections: tuple[Correction, ...]
    groups: tuple[Group, ...]
    quality: Quality
    coverage: Coverage | None
    area: Floats | None


def run_data(
    run: Run,
    between: Between,
    *,
    title: str = '',
    bag: Path | None = None,
    site: SiteConfig | None = None,
) -> RunData:
    """
    Read what is told of a run, track by track: what it takes does not grow with their number.

    Parameters
    ----------
    run : Run
        The run.
    between : (float, float)
        From when until before when, s.
    title : str
        Of the report; by default the run's name.
    bag : Path, optional
        Where the run comes from: what it says of late and lost data is told, too.
    site : SiteConfig, optional
        Where its cameras are: what they see is told, too.

    Raises
    ------
    BagError, StoreError
        If something cannot be read.

    """
    stamps = run.stamps()
    first_ns, last_ns = run.between_ns(between)
    stamps = stamps[(stamps >= first_ns) & (stamps < last_ns)]
    times: Floats = np.asarray((stamps - run.began_ns) * 1e-9, np.float64)
    present, error = np.zeros(len(stamps), np.int64), [np.zeros(0, np.float32)]
    origin, tracks = np.array(run.origin()), []
    for track in track_ids(run):
        rows = run.rows(between, tracks=[track], whole=True)
        if len(rows):
            tracks.append(_track(run, rows, origin))
            present[np.searchsorted(stamps, rows.stamp_ns)] += 1
            error.append(_worst(rows))
    tracks.sort(key=lambda each: (-each.seconds, each.summary.track_id))
    known = np.concatenate(error).astype(np.float64)
    known = known[np.isfinite(known) & (known > 0)]
    quantiles = np.quantile(known, [0.5, 0.95]) if len(known) else np.zeros(0)
    is_absolute = run.began_ns >= ABSOLUTE_NS
    began = datetime.fromtimestamp((run.began_ns // 10**9), UTC) if is_absolute else None
    return RunData(
        title or run.name,
        run.name,
        site.name if site else run.site,
        f'{began:%Y-%m-%d %H:%M:%S} UTC' if began else '',
        (max(between[0], 0.0), min(between[1], float(times[-1]) if len(times) else 0.0)),
        tuple(tracks),
        present,
        times,
        tuple(events(run, between=between)),
        tuple(corrections(run, between)),
        tuple(each for each in groups(run, between) if len(each.members) > 1),
        _quality(run, times, quantiles, bag, between),
        site_coverage(site) if site else None,
        np.array(area_from(site.area).exterior.coords)[:-1] if site and site.area else None,
    )


def _track(run: Run, rows: TrackRows, origin: Floats) -> TrackData:
    seconds = (rows.stamp_ns - run.began_ns) * 1e-9
    parts = np.split(seconds, np.flatnonzero(np.diff(rows.stamp_ns) > PAUSE_NS) + 1)
    spells = tuple((float(part[0]), float(part[-1])) for part in parts)
    cells, times = time_in_cells(rows, CELL_M)
    return TrackData(
        summary_of(run, rows),
        spells,
        sum(last - first for first, last in spells),
        cells + np.rint(origin / CELL_M).astype(np.int64),
        times,
    )


def _worst(rows: TrackRows) -> NDArray[np.float32]:
    """Return standard deviations of positions along their worst direction, (n,) m."""
    covariance = rows.column('covariance')[:, :2, :2]
    half = (covariance[:, 0, 0] + covariance[:, 1, 1]) / 2
    spread = np.hypot((covariance[:, 0, 0] - covariance[:, 1, 1]) / 2, covariance[:, 0, 1])
    worst: NDArray[np.float32] = np.sqrt(np.maximum(half + spread, 0.0))
    return worst


def _quality(
    run: Run, times: Floats, error_m: Floats, bag: Path | None, between: Between
) -> Quality:
    steps = np.diff(times)
    interval_s = float(np.median(steps)) if len(steps) else 0.0
    wide = np.flatnonzero(steps > _GAP * interval_s)
    missing = int(np.rint(steps[wide] / interval_s - 1).sum()) if len(wide) else 0
    wide = wide[np.argsort(-steps[wide], kind='stable')]
    gaps = tuple((float(times[at]), float(times[at + 1])) for at in wide.tolist())
    cameras, troubles = _of_bag(run, bag, between) if bag else ((), ())
    return Quality(len(times), missing, interval_s, gaps, error_m, cameras, troubles)


def _of_bag(
    run: Run, bag: Path, between: Between
) -> tuple[tuple[CameraQuality, ...], tuple[Trouble, ...]]:
    """Return what a bag says of its cameras and of faults."""
    first_ns, last_ns = run.between_ns(between)
    ticks: Sequence[Ticks] = ()
    counts: Counter[tuple[str, str]] = Counter()
    first: dict[tuple[str, str], int] = {}
    with BagReader(bag) as reader:
        if reader.count('/ticks') and run.cameras:
            ticks = [rows for rows, _ in reader.rows('/ticks', Ticks)]
            ticks = [rows for rows in ticks if first_ns <= rows.stamp_ns < last_ns]
        if reader.count('/diagnostics'):
            for _, message, log_ns in reader.messages(['/diagnostics']):
                for status in message.status:
                    if int(status.level) >= _WARNING and first_ns <= log_ns < last_ns:
                        key = status.name, status.message
                        counts[key] += 1
                        first.setdefault(key, log_ns)
    troubles = tuple(
        Trouble(*key, count, run.seconds(first[key])) for key, count in counts.most_common()
    )
    if not ticks:
        return (), troubles
    drops = drops_of(ticks, run.began_ns, len(run.cameras))
    alive = np.zeros(len(run.cameras), np.int64)
    for rows in ticks:
        np.add.at(alive, rows.camera, rows.alive)
    return tuple(
        CameraQuality(
            name,
            {count: int(drops.per_camera(count)[at]) for count in COUNTS},
            1 - float(alive[at]) / len(ticks),
        )
        for at, name in enumerate(run.cameras)
    ), troubles
