"""The table of tracks: from when to when each was there, and in how many rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, func

from mctrack_ros.store import blocks
from mctrack_ros.store.blocks import Words
from mctrack_ros.store.rows import Stored
from mctrack_ros.store.schema import TRACKS, upsert


def add_tracks(
    connection: Connection, stored: Stored, rows: tuple[NDArray[np.int64], Words]
) -> None:
    """Count rows, which come after those of before: stamps, ns, ascending, and their numbers."""
    stamp_ns, words = rows
    if not len(words):
        return
    order = np.argsort(words[:, blocks.ID], kind='stable')
    ids, class_id = words[order, blocks.ID], blocks.column(words, 'class_id')[order]
    values = []
    for part in np.split(np.arange(len(order)), np.flatnonzero(np.diff(ids)) + 1):
        classes = class_id[part][class_id[part] != 0]
        values.append(
            {
                'run_id': stored.run,
                'track_id': int(ids[part[0]]),
                'began_ns': int(stamp_ns[order[part[0]]]),
                'ended_ns': int(stamp_ns[order[part[-1]]]),
                'positions': len(part),
                'class_id': int(classes[-1]) if len(classes) else 0,
            }
        )
    statement = upsert(connection, TRACKS)
    known = func.coalesce(func.nullif(statement.excluded.class_id, 0), TRACKS.c.class_id)
    kept = {
        'ended_ns': statement.excluded.ended_ns,
        'positions': TRACKS.c.positions + statement.excluded.positions,
        'class_id': known,
    }
    connection.execute(
        statement.on_conflict_do_update(index_elements=['run_id', 'track_id'], set_=kept), values
    )
