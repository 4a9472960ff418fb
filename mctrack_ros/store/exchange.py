"""Runs into files of other tools, and tracks of such files into databases and bags."""

from __future__ import annotations

import fnmatch
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagWriter, is_bag
from mctrack_ros.recording.bags.site_topic import SITE_TOPIC
from mctrack_ros.recording.tracks.collected import Layout
from mctrack_ros.recording.tracks.formats import Format
from mctrack_ros.recording.tracks.pitch import Pitch
from mctrack_ros.recording.tracks.track_writer import Frames, frame_rate
from mctrack_ros.store.bags import TRACKS_TOPIC, store_bag
from mctrack_ros.store.database import Database
from mctrack_ros.store.errors import StoreError
from mctrack_ros.store.queries.run import ALWAYS, Between, Run, View
from mctrack_ros.store.queries.runs import runs
from mctrack_ros.store.queries.tracks import windows
from mctrack_ros.store.rows import TrackRows
from mctrack_ros.store.runs import NewRun
from mctrack_ros.store.writer import TrajectoryWriter

Progress = Callable[[int, int], None]

_USUAL_NS = 40_000_000
"""Time between ticks where a run has one alone, ns."""
_GAP = 1.5
"""Gap, in usual ones, from which ticks are missing."""


@dataclass(frozen=True, slots=True)
class Export:
    """
    What a file is made of, beside the run.

    Attributes
    ----------
    between : (float, float)
        From when until before when, s.
    rate_hz : float, optional
        Frames a second; by default as many as the run has ticks.
    pitch : Pitch, optional
        For sports formats, in the coordinates of the site's files.
    away : frozenset of int, optional
        Ids of the away team; see `Layout`.

    """

    between: Between = ALWAYS
    rate_hz: float | None = None
    pitch: Pitch | None = None
    away: frozenset[int] | None = None


@dataclass(frozen=True, slots=True)
class Exported:
    """
    What was written.

    Attributes
    ----------
    files : tuple of Path
        Where.
    positions, tracks : int
        How many.
    rate_hz : float, optional
        Frames a second, in formats that have such.
    moved_s : float
        How far an instant was moved to its frame at most, s.
    left_out : int
        Instants that are not in the file: another had their frame.

    """

    files: tuple[Path, ...]
    positions: int
    tracks: int
    rate_hz: float | None = None
    moved_s: float = 0.0
    left_out: int = 0


@contextmanager
def opened_run(place: str | Path, name: str = '', view: View | None = None) -> Iterator[Run]:
    """
    Open a run of a database, or of a bag, which is stored in a database of its own meanwhile.

    Parameters
    ----------
    place : str or Path
        Database, bag, or folder in which `mctrack track` wrote one.
    name : str
        Name of the run, if the database has several.
    view : View, optional
        Which identities are seen.

    Raises
    ------
    BagError, StoreError
        If there is no such run, or it has no tracks.

    """
    with _stored(place) as database, Run(database, name, view) as run:
        yield run


@contextmanager
def opened_runs(place: str | Path, pattern: str, view: View | None = None) -> Iterator[list[Run]]:
    """
    Open the runs whose names fit a pattern such as ``match*``, in the order of time.

    Whatever has no wildcard is a name; parameters and errors as for `opened_run`.
    """
    if not set('*?[') & set(pattern):
        with opened_run(place, pattern, view) as run:
            yield [run]
        return
    with _stored(place) as stored, Database(stored) as database:
        known = [each.run for each in runs(database) if each.began is not None]
        found = fnmatch.filter(known, pattern)
        if not found:
            raise StoreError(f'the database has no run {pattern} with tracks')
        yield [Run(database, name, view) for name in found]


@contextmanager
def _stored(place: str | Path) -> Iterator[str | Path]:
    """Yield the database at a place, or one that holds the bag there."""
    bag = bag_of(place)
    with stored_bag(bag) if bag else nullcontext(place) as database:
        yield database


@contextmanager
def stored_bag(bag: Path, progress: Progress = lambda done, total: None) -> Iterator[Path]:
    """Write a bag into a database of its own, which is there meanwhile; yields its path."""
    with tempfile.TemporaryDirectory(prefix='mctrack_') as folder:
        path = Path(folder) / 'tracks.db'
        with Database(path, create=True) as database:
            store_bag(bag, database, progress=progress)
        yield path


def bag_of(place: str | Path) -> Path | None:
    """Return the bag at a place, or that `mctrack track` wrote there; None: there is none."""
    inside = Path(place) / 'bag'
    bag = inside if inside.is_dir() else Path(place)
    return bag if is_bag(bag) else None


def instants(run: Run, between: Between = ALWAYS) -> Iterator[Tracks]:
    """Yield the confirmed, coasting and grouped tracks instant by instant, under today's ids."""
    for rows in windows(run, between, whole=True):
        yield from _split(rows)


def export_tracks(run: Run, path: Path, form: Format, export: Export | None = None) -> Exported:
    """
    Write the tracks of a run into a file of another tool.

    Parameters
    ----------
    run : Run
        The run.
    path : Path
        The file, replaced if it is there.
    form : Format
        Its format.
    export : Export, optional
        What it is made of.

    Raises
    ------
    TableError
        If the format needs a pitch and there is none.

    """
    export = export or Export()
    rate_hz = export.rate_hz or _rate(run, form)
    if form.is_whole and rate_hz % 1:
        raise StoreError(f'the format wants a whole number of frames a second, not {rate_hz:g}')
    frames = Frames(rate_hz, run.began_ns)
    layout = Layout(
        frames.period_ns,
        frames.origin_ns,
        run.origin(),
        run.frame_id,
        export.pitch,
        export.away,
    )
    if form.is_on_pitch:
        layout.on_pitch()
    positions, ids = 0, set[int]()
    with form.write(path, layout) as writer:
        for rows in instants(run, export.between):
            if form.has_frames and not frames.admits(rows.stamp_ns):
                continue
            writer.write(rows)
            positions += len(rows)
            ids.update(rows.track_id.tolist())
    made = Exported(tuple(form.files(path)), positions, len(ids))
    if not form.has_frames:
        return made
    moved_s, left_out = frames.moved_ns * 1e-9, frames.left_out
    return replace(made, rate_hz=rate_hz, moved_s=moved_s, left_out=left_out)


def store_tracks(
    tracks: Sequence[Tracks], database: Database, run: NewRun, description: str = ''
) -> None:
    """
    Write tracks into a database, as a run.

    Parameters
    ----------
    tracks : sequence of Tracks
        Ascending.
    database : Database
        Where they go.
    run : NewRun
        What the run is.
    description : str
        What `/site` would say.

    Raises
    ------
    StoreError
        If the run is there already.

    """
    with TrajectoryWriter(database, run) as writer:
        if description:
            writer.write_description(description, tracks[0].stamp_ns)
        for rows in tracks:
            writer.write_tracks(rows)


def write_tracks_bag(
    tracks: Sequence[Tracks],
    bag: Path,
    frame_id: str,
    description: str = '',
    *,
    overwrite: bool = False,
) -> None:
    """Write tracks, ascending, as a bag with `/tracks`, and `/site` if it says anything."""
    with BagWriter(bag, overwrite=overwrite) as writer:
        if description:
            writer.write_text(SITE_TOPIC, description, tracks[0].stamp_ns)
        for rows in tracks:
            writer.write_rows(TRACKS_TOPIC, rows, frame_id, rows.stamp_ns)


def _rate(run: Run, form: Format) -> float:
    """Return how many frames a second a file has: as many as the run has ticks."""
    gaps = np.diff(run.stamps())
    usual = gaps[gaps < _GAP * np.median(gaps)] if len(gaps) else np.array([_USUAL_NS])
    return frame_rate(float(usual.mean()), whole=form.is_whole)


def _split(rows: TrackRows) -> Iterator[Tracks]:
    """Yield rows instant by instant."""
    columns = [
        rows.life.astype(np.uint32) if name == 'track_id' else rows.column(name)
        for name in Tracks.COLUMNS
    ]
    cuts = (np.flatnonzero(np.diff(rows.stamp_ns)) + 1).tolist()
    for first, last in pairwise([0, *cuts, len(rows)]):
        if last > first:
            yield Tracks.adopt(
                int(rows.stamp_ns[first]), [values[first:last] for values in columns]
            )
