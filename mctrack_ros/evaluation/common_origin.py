"""A common origin for the positions of two recordings."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagReader, is_bag, mot_text_place, stated_origin
from mctrack_ros.recording.tables.columns import has_header, read_lines
from mctrack_ros.recording.tracks.track_table import track_table_place
from mctrack_ros.site.origin import chosen_origin
from mctrack_ros.site.stated_origin import Origin


def common_origin(paths: tuple[str | Path, ...]) -> Origin:
    """
    Return the common origin: that of a bag, else a point near the text's positions.

    Text has the coordinates of the site's files, a bag positions relative to its ``/site``'s
    origin; one without, from the other's.
    """
    bags = [path for path in paths if is_bag(path)]
    for path in bags:
        with BagReader(path) as reader:
            stated = stated_origin(reader)
        if stated is not None:
            return stated
    places = [_place(path) for path in paths if not bags and Path(path).is_file()]
    return chosen_origin(np.array(place) for place in places if place is not None)


def _place(path: str | Path) -> Origin | None:
    """Return the first position in a text, m."""
    return track_table_place(path) if has_header(read_lines(path)) else mot_text_place(path)


def moved_to(instants: list[Tracks], stated: Origin | None, origin: Origin | None) -> list[Tracks]:
    """Return instants relative to one origin made relative to another."""
    if stated is None or origin is None or stated == origin:
        return instants
    by = np.append(np.subtract(stated, origin), 0.0)
    return [rows.replace(position=rows.position + by) for rows in instants]
