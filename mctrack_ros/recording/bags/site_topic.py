"""What `/site` says in a bag."""

from __future__ import annotations

import json

from mctrack_ros.recording.bags.bag import BagReader

SITE_TOPIC = '/site'


def stated_clock_offsets(reader: BagReader) -> dict[str, float]:
    """Return what was taken from the stamps of a bag's detections, s, as its `/site` says."""
    for _, message, _ in reader.messages([SITE_TOPIC]) if reader.count(SITE_TOPIC) else ():
        try:
            stated = json.loads(message.data)['clock_offsets']
            return {str(name): float(offset) for name, offset in stated.items()}
        except (ValueError, TypeError, KeyError, AttributeError):
            return {}
    return {}


def stated_origin(reader: BagReader) -> tuple[float, float] | None:
    """Return the origin of a bag's positions, m; None if its `/site` does not say."""
    for _, message, _ in reader.messages([SITE_TOPIC]) if reader.count(SITE_TOPIC) else ():
        try:
            x, y = json.loads(message.data)['origin']
            return float(x), float(y)
        except (ValueError, TypeError, KeyError):
            return None
    return None
