"""What the positions of two recordings are told from, so that they can be compared."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagReader, is_bag, mot_text_place, stated_origin
from mctrack_ros.recording.tables.columns import has_header, read_lines
from mctrack_ros.recording.tables.track_table import track_table_place
from mctrack_ros.site.origin import chosen_origin
from mctrack_ros.site.stated_origin import Origin


def common_origin(paths: tuple[str | Path, ...]) -> Origin:
    """
    Return what to tell the positions of bags and texts from: as a bag says, else near a text's.

    Text has the coordinates of the site's files, a bag tells positions from its ``/site``'s
    origin; one without, from the other's.
    """
    bags = [path for path in paths if is_bag(path)]
    for path in bags:
        with BagReader(path) as reader:
            told = stated_origin(reader)
        if told is not None:
            return told
    places = [_place(path) for path in paths if not bags and Path(path).is_file()]
    return chosen_origin(np.array(place) for place in places if place is not None)


def _place(path: str | Path) -> Origin | None:
    """Return the first position in a text, m."""
    return track_table_place(path) if has_header(read_lines(path)) else mot_text_place(path)


def retold(instants: list[Tracks], told: Origin | None, origin: Origin | None) -> list[Tracks]:
    """Return instants whose positions are told from one origin, told from another."""
    if told is None or origin is None or told == origin:
        return instants
    by = np.append(np.subtract(told, origin), 0.0)
    return [rows.replace(position=rows.position + by) for rows in instants]
