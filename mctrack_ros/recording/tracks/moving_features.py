"""
OGC Moving Features in JSON (OGC 19-045r3): tracks with the time of each position.

The encoding *Trajectory* is GeoJSON, a line a track with the times among its properties: maps show
it. The encoding *Prism* has moving points. A track that was away for longer than `PAUSE_NS` is
several features of the same ``track_id``: nobody walks from where it ended to where it began.
"""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.input_size import TABLE, check_size
from mctrack_ros.interfaces import PAUSE_NS, ClassCode, Tracks
from mctrack_ros.recording.tables.class_names import CLASS_NAMES
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tracks.collected import (
    Collected,
    CollectingWriter,
    Ints,
    Layout,
    instants_of,
)

_TIMES = {'type': 'Name', 'properties': {'name': 'urn:ogc:data:time:iso8601'}}


class _FeatureWriter(CollectingWriter):
    """Write a collection of features."""

    def _finish(self, rows: Collected) -> None:
        place = {'type': 'Name', 'properties': {'name': self._layout.frame_id}}
        head = json.dumps({'type': 'FeatureCollection', 'crs': place, 'trs': _TIMES})
        with self._path.open('w') as file:
            file.write(head[:-1] + ', "features": [')
            before = '\n'
            for track_id, part in rows.by_track().items():
                name = rows.class_of(part).name.lower()
                for piece in np.split(
                    part, np.flatnonzero(np.diff(rows.stamp_ns[part]) > PAUSE_NS) + 1
                ):
                    places = np.round(rows.position[piece, :2], 4).tolist()
                    feature = self._feature(track_id, name, places, _texts(rows.stamp_ns[piece]))
                    file.write(before + json.dumps(feature, separators=(',', ':')))
                    before = ',\n'
            file.write('\n]}\n')

    @abstractmethod
    def _feature(
        self, track_id: int, class_name: str, places: list[Any], times: list[str]
    ) -> dict[str, Any]:
        """Return a piece of a track."""


class TrajectoryFeatureWriter(_FeatureWriter):
    """Write GeoJSON whose lines have times: the encoding Trajectory."""

    def _feature(
        self, track_id: int, class_name: str, places: list[Any], times: list[str]
    ) -> dict[str, Any]:
        is_line = len(places) > 1
        shape = {'type': 'LineString' if is_line else 'Point'}
        return {
            'type': 'Feature',
            'geometry': shape | {'coordinates': places if is_line else places[0]},
            'properties': {'track_id': [track_id], 'class': [class_name], 'datetimes': times},
        }


class PrismWriter(_FeatureWriter):
    """Write moving points: the encoding Prism."""

    def _feature(
        self, track_id: int, class_name: str, places: list[Any], times: list[str]
    ) -> dict[str, Any]:
        return {
            'type': 'Feature',
            'properties': {'track_id': track_id, 'class': class_name},
            'temporalGeometry': {
                'type': 'MovingPoint',
                'datetimes': times,
                'coordinates': places,
                'interpolation': 'Linear',
            },
        }


def read_moving_features(path: str | Path, layout: Layout) -> list[Tracks]:
    """
    Read tracks from either encoding.

    ``track_id`` among the properties, or else ``id`` of a feature, says which features are of one
    track, where they are whole numbers; otherwise each feature is a track.

    Raises
    ------
    TableError
        If the file holds no moving features; says why.

    """
    check_size(path, TABLE, TableError)
    try:
        content = json.loads(Path(path).read_text(encoding='utf-8'))
        features = [content] if content['type'] == 'Feature' else content['features']
        read = [_read_feature(feature) for feature in features]
    except (OSError, UnicodeDecodeError) as error:
        raise TableError(f'{path} cannot be read: {error}') from error
    except (ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        raise TableError(f'{path} holds no moving features: {error!r}') from error
    ids = [track_id for track_id, _, _, _ in read]
    if None in ids:
        ids = list(range(1, len(read) + 1))
    counts = [len(stamps) for _, _, stamps, _ in read]
    if not sum(counts):
        return []
    columns = {
        'track_id': np.repeat(np.array(ids, np.int64), counts),
        'class_id': np.repeat(np.array([code for _, code, _, _ in read], np.int64), counts),
        'position': np.concatenate([places for _, _, _, places in read]),
    }
    return instants_of(
        np.concatenate([stamps for _, _, stamps, _ in read]), columns, layout.origin
    )


def _read_feature(
    feature: dict[str, Any],
) -> tuple[int | None, ClassCode, Ints, NDArray[np.float64]]:
    """Return id, class, stamps, ns, and places, (n, 3) m."""
    said = feature.get('properties') or {}
    if 'temporalGeometry' in feature:
        moving = feature['temporalGeometry']
        if moving['type'] != 'MovingPoint':
            raise ValueError(f'{moving["type"]}, expected MovingPoint')
        times, coordinates = moving['datetimes'], moving['coordinates']
    else:
        times, shape = said['datetimes'], feature['geometry']
        coordinates = shape['coordinates']
        if shape['type'] == 'Point':
            coordinates = [coordinates]
        elif shape['type'] != 'LineString':
            raise ValueError(f'{shape["type"]}, expected LineString')
    if len(times) != len(coordinates):
        raise ValueError(f'{len(coordinates)} positions, but {len(times)} times')
    places = [(*place[:2], *(place[2:3] or [0.0])) for place in coordinates]
    track_id = _only(said.get('track_id', feature.get('id')))
    named = str(_only(said.get('class')) or '').lower()
    is_number = str(track_id).isdecimal() and int(track_id) < 2**32
    return (
        int(track_id) if is_number else None,
        CLASS_NAMES.get(named, ClassCode.UNKNOWN),
        np.array(list(_stamps(times)), np.int64),
        np.array(places, np.float64).reshape(-1, 3),
    )


def _only(value: Any) -> Any:
    return value[0] if isinstance(value, list) and len(value) == 1 else value


def _texts(stamp_ns: Ints) -> list[str]:
    """Return stamps as ISO 8601 in UTC, to the nanosecond."""
    texts = np.datetime_as_string(stamp_ns.astype('datetime64[ns]'), unit='ns')
    return [f'{text}Z' for text in texts.tolist()]


def _stamps(times: list[Any]) -> Iterator[int]:
    """Yield stamps, ns, of ISO 8601, or of milliseconds since 1970."""
    for time in times:
        if not isinstance(time, str):
            yield round(time * 1_000_000)
        elif time.endswith('Z'):
            yield int(np.datetime64(time[:-1], 'ns').astype(np.int64))
        else:
            stamp = datetime.fromisoformat(time)
            stamp = stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)
            whole = int(stamp.timestamp() // 1)
            yield whole * 10**9 + stamp.microsecond * 1000
