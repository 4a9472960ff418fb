"""Messages of a few ticks in which something happens, and their frames."""

import numpy as np

from mctrack_ros.interfaces import EventCode, Events, Tracks, TrackStatus
from mctrack_ros.streams.frames import About, Assembler

BEGAN_NS = 1_700_000_000_000_000_000
PERIOD_NS = 40_000_000
ABOUT = About('night & day', 'map', (389000.0, 5820000.0), 2 * PERIOD_NS, ('goal', 'ground/1'))
SITE = {
    'run': ABOUT.run,
    'origin': ABOUT.origin,
    'fusion': {'reid': {'lost_time': ABOUT.lost_ns / 1e9}},
    'zones': [{'index': n, 'name': name} for n, name in enumerate(ABOUT.zones, start=1)],
}
"""What `/site` says of it."""


def stamp_ns(tick):
    return BEGAN_NS + tick * PERIOD_NS


def tracks(tick, ids, groups=(), **columns):
    """Return tracks that walk along x, by id; a group's members name it."""
    random = np.random.default_rng(tick)
    roots = random.normal(size=(len(ids), 4, 4))
    values = {
        'position': [(track + 0.01 * tick, -2.5 * track, 0.0) for track in ids],
        'velocity': [(0.25, 0.0)] * len(ids),
        'covariance': roots @ roots.transpose(0, 2, 1) / 100,
        'track_id': ids,
        'group': groups or [0] * len(ids),
        'status': [TrackStatus.CONFIRMED] * len(ids),
        'class_id': [1] * len(ids),
    }
    return Tracks.build(stamp_ns(tick), **(values | columns))


def events(tick, *rows):
    """Return events, each a mapping of columns."""
    names = sorted({name for row in rows for name in row})
    padded = [{name: row.get(name, 0) for name in names} for row in rows]
    columns = {name: [row[name] for row in padded] for name in names}
    if 'others' in columns:
        columns['others'] = [[*(each or []), *[0] * 16][:16] for each in columns['others']]
    return Events.build(stamp_ns(tick), **columns)


def story():
    """Yield the messages of ticks: two meet, part, one is renamed, one ends, one is absorbed."""
    merge, split, correction = EventCode.MERGE, EventCode.SPLIT, EventCode.CORRECTION
    yield tracks(0, [1, 2, 3]), events(0, {'event': EventCode.NEW, 'track_id': 1})
    yield (
        tracks(1, [1, 2, 3], [1, 1, 0]),
        events(1, {'event': merge, 'track_id': 2, 'others': [1, 2]}),
    )
    yield tracks(2, [1, 2, 3]), events(2, {'event': split, 'track_id': 1})
    renamed = {'event': correction, 'track_id': 7, 'old_id': 3, 'new_id': 7, 'probability': 0.9}
    yield tracks(3, [1, 2, 7]), events(3, renamed)
    ended = [TrackStatus.CONFIRMED, TrackStatus.CONFIRMED, TrackStatus.DELETED]
    yield (
        tracks(4, [1, 2, 7], status=ended),
        events(4, {'event': EventCode.EXIT, 'track_id': 7, 'position': (np.nan,) * 3}),
    )
    absorbed = {'event': correction, 'track_id': 1, 'old_id': 2, 'new_id': 1}
    yield (
        tracks(5, [1], position=[(np.nan, 0.0, 0.0)]),
        events(5, absorbed, {'event': EventCode.EXIT, 'track_id': 2}),
    )
    parted = {'event': split, 'track_id': 9, 'old_id': 1, 'new_id': 9}
    crossed = {'event': EventCode.CROSS_LEFT, 'track_id': 9, 'zone': 2}
    emptied = {'event': EventCode.OCCUPANCY, 'zone': 1, 'old_id': 2, 'new_id': 0}
    unknown = {'event': 99, 'track_id': 9, 'zone': 3}  # of a later version
    yield tracks(6, [1, 9]), events(6, parted, crossed, emptied, unknown)
    yield tracks(7, [1, 9]), None
    yield tracks(8, []), None


def frames_of(messages):
    """Return the frames of messages."""
    assembler = Assembler(ABOUT)
    frames = []
    for rows, told in messages:
        assembler.add_tracks(rows)
        if told is not None:
            assembler.add_events(told)
        frames.append(assembler.finish())
    return frames
