"""Tracks for the tests of zones: rows of a tick, corrections, walks across an edge."""

import numpy as np

from mctrack_ros.interfaces import EventCode, Events, Tracks

TICK_NS = 40_000_000
BEGAN_NS = 10_000_000_000


def stamp_ns(tick):
    return BEGAN_NS + tick * TICK_NS


def tracks(tick, places, sigma=0.1, **columns):
    """Return tracks by id -> (x, y)."""
    covariance = np.zeros((len(places), 4, 4))
    covariance[:, [0, 1], [0, 1]] = sigma**2
    position = [(x, y, 0.0) for x, y in places.values()]
    return Tracks.build(
        stamp_ns(tick),
        track_id=list(places),
        position=np.reshape(position, (-1, 3)),
        covariance=covariance,
        **columns,
    )


def corrections(tick, *pairs):
    """Return the corrections (old, new) of a tick."""
    old, new = zip(*pairs) if pairs else ((), ())
    return Events.build(
        stamp_ns(tick),
        event=[EventCode.CORRECTION] * len(pairs),
        track_id=new,
        old_id=old,
        new_id=new,
    )


def happened(events, *names):
    """Return events of some codes as (name, track, zone)."""
    rows = zip(events.event.tolist(), events.track_id.tolist(), events.zone.tolist())
    told = [(EventCode(code).name, track, zone) for code, track, zone in rows]
    return [each for each in told if not names or each[0] in names]
