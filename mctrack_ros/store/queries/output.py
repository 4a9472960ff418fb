"""Answers as text and files."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import asdict, fields
from enum import StrEnum
from pathlib import Path
from typing import Any

from mctrack_ros.recording.tracks.parquet import pyarrow_for


class Format(StrEnum):
    """How answers are written."""

    TABLE = 'table'
    JSON = 'json'
    GEOJSON = 'geojson'
    CSV = 'csv'
    PARQUET = 'parquet'


def as_json(rows: Sequence[Any]) -> str:
    """Return rows as a list of objects."""
    return json.dumps([asdict(row) for row in rows], indent=1)


def as_geojson(rows: Sequence[Any]) -> str:
    """
    Return rows as a collection of features, in metres of the site's frame.

    A row with ``x`` and ``y`` is a point; others have no geometry.
    """
    features = []
    for row in rows:
        properties = asdict(row)
        x, y = properties.pop('x', None), properties.pop('y', None)
        geometry = None if x is None else {'type': 'Point', 'coordinates': [x, y]}
        features.append({'type': 'Feature', 'geometry': geometry, 'properties': properties})
    return json.dumps({'type': 'FeatureCollection', 'features': features}, indent=1)


def as_csv(rows: Sequence[Any], kind: type[Any]) -> str:
    """Return rows as text with a header; several ids in one field are parted by blanks."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(field.name for field in fields(kind))
    writer.writerows(map(_plain, asdict(row).values()) for row in rows)
    return text.getvalue()


def write_parquet(rows: Sequence[Any], kind: type[Any], path: Path) -> None:
    """Write rows as a Parquet file; TableError: pyarrow is not there, or not for this numpy."""
    arrow, parquet = pyarrow_for(path)
    names = [field.name for field in fields(kind)]
    columns = {name: [getattr(row, name) for row in rows] for name in names}
    parquet.write_table(arrow.Table.from_pydict(columns), path)


def cells(row: Any) -> list[str]:
    """Return a row for a table that people read."""
    return [_short(value) for value in asdict(row).values()]


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f'{value:.3f}'
    return '-' if value is None else str(_plain(value))


def _plain(value: Any) -> Any:
    return ' '.join(map(str, value)) if isinstance(value, tuple) else value
