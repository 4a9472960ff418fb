"""What a cell's corrections of its own ids mean for the site."""

from __future__ import annotations

import numpy as np

from mctrack_ros.fusion.cells.links import OPEN, Links
from mctrack_ros.fusion.table import TrackTable


def corrected(
    links: Links, table: TrackTable, cell: int, changes: dict[int, int], stamp_ns: int
) -> dict[int, int]:
    """
    Change the links by a cell's corrections, which name the same bodies otherwise.

    Where no other cell sees who is renamed, the cell is believed: its new name is the target
    that it was before. Who is seen elsewhere stays who he is, unless the new name is of a
    target that nobody sees now: then that one is found again.

    Parameters
    ----------
    links : Links
        Are changed.
    table : TrackTable
        The targets; `cameras` has who saw them last.
    cell : int
        Whose corrections they are.
    changes : dict of int to int
        Ids of the cell, old to new.
    stamp_ns : int
        Of the tick, ns.

    Returns
    -------
    dict of int to int
        Targets that turned out to be others, old to new.

    """
    seen = dict(zip(table.track_id.tolist(), table.cameras.tolist()))
    before = {old: links.target((cell, old)) for old in changes}
    named = {new: links.target((cell, new)) for new in changes.values()}
    renamed: dict[int, int] = {}
    others = int(~np.uint32(1 << cell))
    for old, new in changes.items():
        body, name = before[old], named[new]
        if body not in seen:
            continue
        if name not in seen or name == body:
            links.put((cell, new), body, stamp_ns)
        elif not seen[name] and name not in before.values():
            links.rename(body, name)
            renamed[body] = name
        elif not (seen[body] | seen[name]) & others:
            renamed[body] = name
        else:
            links.put((cell, new), body, stamp_ns)
    for old in changes.keys() - set(changes.values()):
        links.put((cell, old), OPEN, stamp_ns)
    return renamed
