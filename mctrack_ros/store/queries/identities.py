"""Questions about identities: what was corrected, and who was in which group."""

from __future__ import annotations

import numpy as np
from sqlalchemy import select

from mctrack_ros.store.queries.results import Correction, Group
from mctrack_ros.store.queries.run import ALWAYS, Between, Run
from mctrack_ros.store.schema import CORRECTIONS, MEMBERS


def corrections(run: Run, between: Between = ALWAYS) -> list[Correction]:
    """Return the corrections of identities, in the order of time."""
    first_ns, last_ns = run.between_ns(between)
    asked = select(CORRECTIONS).where(
        CORRECTIONS.c.run_id == run.stored.run,
        CORRECTIONS.c.stamp_ns >= first_ns,
        CORRECTIONS.c.stamp_ns < last_ns,
    )
    order = (CORRECTIONS.c.stamp_ns, CORRECTIONS.c.number, CORRECTIONS.c.line)
    with run.database.connected() as connection:
        return [
            Correction(
                run.seconds(row.stamp_ns),
                run.seconds(row.since_ns),
                row.old_id,
                row.new_id,
                row.probability,
            )
            for row in connection.execute(asked.order_by(*order))
        ]


def groups(run: Run, between: Between = ALWAYS) -> list[Group]:
    """Return who was together, in the order of time; a group that began earlier counts too."""
    first_ns, last_ns = run.between_ns(between)
    asked = select(MEMBERS).where(
        MEMBERS.c.run_id == run.stored.run,
        MEMBERS.c.ended_ns >= first_ns,
        MEMBERS.c.began_ns < last_ns,
    )
    with run.database.connected() as connection:
        identities = run.identities(connection)
        rows = connection.execute(asked.order_by(MEMBERS.c.began_ns, MEMBERS.c.track_id)).all()
    ids = np.array([row.track_id for row in rows], np.int64)
    lives = identities.lives(ids, np.array([row.began_ns for row in rows], np.int64))
    found: dict[int, Group] = {}
    for row, life in zip(rows, lives.tolist()):
        began_s, ended_s = run.seconds(row.began_ns), run.seconds(row.ended_ns)
        before = found.get(row.group_id, Group(row.group_id, began_s, ended_s, ()))
        found[row.group_id] = Group(
            row.group_id,
            before.began_s,
            max(before.ended_s, ended_s),
            tuple(sorted({*before.members, life})),
        )
    return list(found.values())
