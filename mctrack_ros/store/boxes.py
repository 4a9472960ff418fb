"""The index of the chunks' boxes in space, time and run: R*Tree in SQLite, GiST in PostGIS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, TextClause, text

FAR = 1e12
"""Beyond every place and time, m and s."""


@dataclass(frozen=True, slots=True)
class Box:
    """
    A box in a run; bounds included.

    Attributes
    ----------
    run : int
        The run's number.
    began, ended : float
        Since the run's first tick, s.
    left, right, low, high : float
        Smallest and largest x and y, m.

    """

    run: int
    began: float = -FAR
    ended: float = FAR
    left: float = -FAR
    right: float = FAR
    low: float = -FAR
    high: float = FAR

    def values(self) -> dict[str, Any]:
        """Return the bounds by name."""
        return {name: getattr(self, name) for name in self.__slots__}


class RTree:
    """SQLite's R*Tree, of 32-bit numbers that are rounded outwards."""

    CREATE = (
        'CREATE VIRTUAL TABLE boxes USING rtree(chunk_id, run0, run1, began, ended, '
        'left0, right0, low0, high0)',
    )
    DROP = ('DROP TABLE boxes',)
    INSERT = text(
        'INSERT INTO boxes VALUES (:chunk_id, :run, :run, :began, :ended, '
        ':left, :right, :low, :high)'
    )
    FIND = text(
        'SELECT chunk_id FROM boxes WHERE run0 <= :run AND run1 >= :run AND began <= :ended AND '
        'ended >= :began AND left0 <= :right AND right0 >= :left AND low0 <= :high '
        'AND high0 >= :low'
    )


class GiST:
    """PostGIS: a line from corner to corner in x, y, time and run."""

    CREATE = (
        'CREATE EXTENSION IF NOT EXISTS postgis',
        'CREATE TABLE boxes (chunk_id bigint PRIMARY KEY, box geometry(LineStringZM) NOT NULL)',
        'CREATE INDEX boxes_box ON boxes USING gist (box gist_geometry_ops_nd)',
        'ALTER TABLE chunks ALTER COLUMN places SET STORAGE EXTERNAL',
        'ALTER TABLE rests ALTER COLUMN rest SET STORAGE EXTERNAL',
    )
    DROP = ('DROP TABLE boxes',)
    _LINE = (
        'ST_MakeLine(ST_MakePoint(:left, :low, :began, :run), '
        'ST_MakePoint(:right, :high, :ended, :run))'
    )
    INSERT = text(f'INSERT INTO boxes VALUES (:chunk_id, {_LINE})')
    FIND = text(f'SELECT chunk_id FROM boxes WHERE box &&& {_LINE}')


INDICES: dict[str, type[RTree | GiST]] = {'sqlite': RTree, 'postgresql': GiST}
"""By the name of the back end."""


def insert_boxes(connection: Connection, boxes: Sequence[tuple[int, Box]]) -> None:
    """Add the boxes of chunks."""
    if boxes:
        values = [{'chunk_id': chunk, **box.values()} for chunk, box in boxes]
        connection.execute(_statement(connection, 'INSERT'), values)


def find_chunks(connection: Connection, box: Box) -> list[int]:
    """Return which chunks may reach into a box."""
    return list(connection.execute(_statement(connection, 'FIND'), box.values()).scalars())


def _statement(connection: Connection, name: str) -> TextClause:
    statement: TextClause = getattr(INDICES[connection.dialect.name], name)
    return statement
