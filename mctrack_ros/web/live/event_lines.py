"""Events as the browser takes them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from mctrack_ros.interfaces import EventCode, Events
from mctrack_ros.store.queries.results import Event


def event_lines(events: Events, zones: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Yield one mapping for each row of `/events`; zones and lines are named in their order."""
    for row in range(len(events)):
        x, y = events.position[row, :2].tolist()
        code = int(events.event[row])
        yield {
            'time': events.stamp_ns / 1e9,
            'event': event_name(code),
            'track': int(events.track_id[row]),
            'old': int(events.old_id[row]),
            'new': int(events.new_id[row]),
            'others': [each for each in events.others[row].tolist() if each],
            'zone': _zone_name(int(events.zone[row]), zones),
            'place': [x, y] if math.isfinite(x) and math.isfinite(y) else None,
        }


def stored_line(event: Event) -> dict[str, Any]:
    """Return the mapping of an event of the database."""
    is_placed = event.x is not None and event.y is not None
    return {
        'time': event.stamp_ns / 1e9,
        'event': event.event,
        'track': event.track_id,
        'old': event.old_id,
        'new': event.new_id,
        'others': list(event.others),
        'zone': event.zone,
        'place': [event.x, event.y] if is_placed else None,
    }


def event_name(code: int) -> str:
    """Return the name of an event's code, in small letters."""
    try:
        return EventCode(code).name.lower()
    except ValueError:
        return f'event {code}'


def _zone_name(zone: int, zones: Sequence[str]) -> str:
    if not zone:
        return ''
    return zones[zone - 1] if zone <= len(zones) else str(zone)
