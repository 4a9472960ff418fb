"""The index of the chunks' boxes in space, time and run: R*Tree in SQLite, GiST in PostGIS."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass

from sqlalchemy import Connection, text

FAR = 1e12
"""Beyond every place and time, m and s."""
# A box reaches half a run far: volumes of nothing would tell the index nothing.


@dataclass(frozen=True, slots=True)
class Box:
    """
    A box in a run; bounds included.

    Attributes
    ----------
    run : int
        The run's number.
    t0, t1 : float
        From when to when, since the run's first tick, s.
    x0, x1, y0, y1 : float
        Smallest and largest x and y, m.

    """

    run: int
    t0: float = -FAR
    t1: float = FAR
    x0: float = -FAR
    x1: float = FAR
    y0: float = -FAR
    y1: float = FAR

    def holds(self, other: Box) -> bool:
        """Tell whether another lies in it."""
        return (
            self.run == other.run
            and self.t0 <= other.t0 <= other.t1 <= self.t1
            and self.x0 <= other.x0 <= other.x1 <= self.x1
            and self.y0 <= other.y0 <= other.y1 <= self.y1
        )


class RTree:
    """SQLite's R*Tree, of 32-bit numbers that are rounded outwards."""

    CREATE = (
        'CREATE VIRTUAL TABLE boxes USING rtree(chunk_id, run0, run1, t0, t1, x0, x1, y0, y1)',
    )
    DROP = ('DROP TABLE boxes',)
    INSERT = text(
        'INSERT INTO boxes VALUES (:chunk_id, :run, :run + 0.5, :t0, :t1, :x0, :x1, :y0, :y1)'
    )
    FIND = text(
        """
        SELECT DISTINCT chunk_id FROM json_each(:boxes) AS asked CROSS JOIN boxes
        WHERE run0 <= json_extract(asked.value, '$.run')
          AND run1 >= json_extract(asked.value, '$.run')
          AND t0 <= json_extract(asked.value, '$.t1') AND t1 >= json_extract(asked.value, '$.t0')
          AND x0 <= json_extract(asked.value, '$.x1') AND x1 >= json_extract(asked.value, '$.x0')
          AND y0 <= json_extract(asked.value, '$.y1') AND y1 >= json_extract(asked.value, '$.y0')
        """
    )

    READ = text(
        """
        SELECT chunk_id, run0 AS run, t0, t1, x0, x1, y0, y1
        FROM json_each(:chunks) AS asked CROSS JOIN boxes ON chunk_id = asked.value
        """
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
    INSERT = text(
        'INSERT INTO boxes VALUES (:chunk_id, ST_MakeLine(ST_MakePoint(:x0, :y0, :t0, :run), '
        'ST_MakePoint(:x1, :y1, :t1, :run + 0.5)))'
    )
    FIND = text(
        """
        SELECT DISTINCT chunk_id
        FROM json_to_recordset(CAST(:boxes AS json)) AS asked (
            run float8, t0 float8, t1 float8, x0 float8, x1 float8, y0 float8, y1 float8
        )
        JOIN boxes ON box &&& ST_MakeLine(
            ST_MakePoint(asked.x0, asked.y0, asked.t0, asked.run),
            ST_MakePoint(asked.x1, asked.y1, asked.t1, asked.run)
        )
        """
    )
    READ = text(
        """
        SELECT chunk_id, ST_M(low) AS run, ST_Z(low) AS t0, ST_Z(high) AS t1,
               ST_X(low) AS x0, ST_X(high) AS x1, ST_Y(low) AS y0, ST_Y(high) AS y1
        FROM (
            SELECT chunk_id, ST_StartPoint(box) AS low, ST_EndPoint(box) AS high
            FROM json_array_elements_text(CAST(:chunks AS json)) AS asked
            JOIN boxes ON chunk_id = CAST(asked.value AS bigint)
        ) AS ends
        """
    )


INDICES: dict[str, type[RTree | GiST]] = {'sqlite': RTree, 'postgresql': GiST}
"""By the name of the back end."""


_DELETE = text('DELETE FROM boxes WHERE chunk_id = :chunk_id')


def insert_boxes(connection: Connection, boxes: Sequence[tuple[int, Box]]) -> None:
    """Add the boxes of chunks."""
    if boxes:
        values = [{'chunk_id': chunk, **asdict(box)} for chunk, box in boxes]
        connection.execute(INDICES[connection.dialect.name].INSERT, values)


def find_chunks(connection: Connection, boxes: Sequence[Box]) -> list[int]:
    """Return which chunks may reach into one of some boxes."""
    values = [{name: getattr(box, name) for name in Box.__slots__} for box in boxes]
    asked = {'boxes': json.dumps(values)}
    return list(connection.execute(INDICES[connection.dialect.name].FIND, asked).scalars())


def load_boxes(connection: Connection, chunks: Sequence[int]) -> dict[int, Box]:
    """Return the boxes of chunks, of those that have one."""
    found = connection.execute(
        INDICES[connection.dialect.name].READ, {'chunks': json.dumps(list(chunks))}
    )
    return {
        row.chunk_id: Box(int(row.run), row.t0, row.t1, row.x0, row.x1, row.y0, row.y1)
        for row in found
    }


def delete_boxes(connection: Connection, chunks: Sequence[int]) -> None:
    """Delete the boxes of chunks."""
    if chunks:
        connection.execute(_DELETE, [{'chunk_id': chunk} for chunk in chunks])
