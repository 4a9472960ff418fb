"""The formats of tracks: names, endings, writers and readers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, Self

from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tracks.collected import Layout
from mctrack_ros.recording.tracks.epts import EptsWriter, read_epts
from mctrack_ros.recording.tracks.mot_text import MotTextWriter, read_mot_text
from mctrack_ros.recording.tracks.moving_features import (
    PrismWriter,
    TrajectoryFeatureWriter,
    read_moving_features,
)
from mctrack_ros.recording.tracks.parquet import ParquetWriter, read_parquet
from mctrack_ros.recording.tracks.pedestrian_text import PedestrianTextWriter, read_pedestrian_text
from mctrack_ros.recording.tracks.tracab import TracabWriter, read_tracab
from mctrack_ros.recording.tracks.track_table import TrackTableWriter, read_track_table
from mctrack_ros.recording.tracks.xml import metadata_file


class Writer(Protocol):
    """What writes a file, instant by instant."""

    def write(self, rows: Tracks) -> None:
        """Append one instant."""

    def __enter__(self) -> Self:
        """Return the writer."""

    def __exit__(self, *raised: object) -> None:
        """Finish the file."""


@dataclass(frozen=True, slots=True)
class Format:
    """
    A format of tracks.

    Attributes
    ----------
    write : callable
        Opens a writer of a file.
    read : callable
        Returns the instants of a file, ascending; raises `TableError`.
    endings : tuple of str
        Of names that can be of no other format.
    has_frames : bool
        Whether it has a frame rate instead of times.
    is_whole : bool
        Whether that must be a whole number.
    is_on_pitch : bool
        Whether it measures from the centre spot of a pitch and has its metadata beside it.

    """

    write: Callable[[Path, Layout], Writer]
    read: Callable[[Path, Layout], list[Tracks]]
    endings: tuple[str, ...] = ()
    has_frames: bool = False
    is_whole: bool = False
    is_on_pitch: bool = False

    def files(self, path: Path) -> list[Path]:
        """Return the files that are written."""
        return [path, metadata_file(path)] if self.is_on_pitch else [path]


def _write_mot(path: Path, layout: Layout) -> Writer:
    return MotTextWriter(path, layout.period_ns, layout.origin_ns, layout.origin)


def _read_mot(path: Path, layout: Layout) -> list[Tracks]:
    return read_mot_text(path, layout.period_ns, layout.origin_ns, layout.origin)


def _write_table(path: Path, layout: Layout) -> Writer:
    return TrackTableWriter(path, layout.period_ns, layout.origin_ns, layout.origin)


def _read_table(path: Path, layout: Layout) -> list[Tracks]:
    instants, _, counts_frames = read_track_table(path, layout.period_ns, layout.origin)
    if not counts_frames:
        return instants
    return [rows.at(rows.stamp_ns + layout.origin_ns) for rows in instants]


FORMATS = {
    'mot': Format(_write_mot, _read_mot, has_frames=True),
    'csv': Format(_write_table, _read_table, ('.csv',)),
    'parquet': Format(ParquetWriter, read_parquet, ('.parquet',)),
    'geojson': Format(TrajectoryFeatureWriter, read_moving_features, ('.geojson',)),
    'mf-json': Format(PrismWriter, read_moving_features, ('.json', '.mfjson')),
    'pedpy': Format(PedestrianTextWriter, read_pedestrian_text, has_frames=True),
    'epts': Format(EptsWriter, read_epts, (), has_frames=True, is_whole=True, is_on_pitch=True),
    'tracab': Format(
        TracabWriter, read_tracab, ('.dat',), has_frames=True, is_whole=True, is_on_pitch=True
    ),
}
"""By name."""


def format_of(path: Path, name: str = '') -> Format:
    """
    Return a format by its name, or by the ending of a file's.

    Raises
    ------
    TableError
        If it is not known; says which are.

    """
    if name and name not in FORMATS:
        raise TableError(f'--format is {name!r}, expected one of {", ".join(FORMATS)}')
    if name:
        return FORMATS[name]
    ending = path.suffix.lower()
    for each in FORMATS.values():
        if ending in each.endings:
            return each
    raise TableError(f'{path} may be of several formats: --format {", ".join(FORMATS)}')
