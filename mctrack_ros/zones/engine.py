"""Zone events of one tick after another: who enters, leaves, crosses, dwells, and how many."""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import PAUSE_NS, REPORTED, EventCode, Events, Tracks, starts_anew
from mctrack_ros.zones.shapes import Zones
from mctrack_ros.zones.sides import Look, Sides

MEMORY_NS = 120_000_000_000
"""Time for which the last place of a track is kept, should a correction join another to it, ns."""

Rows = NDArray[np.intp]
Lives = NDArray[np.void]


class _Found(NamedTuple):
    """A zone event; its fields are in the order by which events are sorted."""

    event: EventCode
    track_id: int
    zone: int
    position: tuple[float, float, float]
    probability: float
    old_id: int = 0
    new_id: int = 0


class ZoneEngine:
    """
    Follows the tracks of a site through its zones and over its lines.

    A track is inside from the tick that decides so (see `mctrack_ros.zones.sides`) to the tick
    that decides that it is outside, or until it is missing for longer than `PAUSE_NS`. It crosses
    a line when the straight way between two successive places, both clearly off the line, does.

    What is known of a track is its own, not its id's: corrections move it from id to id. If two
    tracks turn out to be one, what was decided last holds, and of a crossing that happened between
    the two an event tells.

    Parameters
    ----------
    zones : Zones
        In the coordinates of the tracks.

    """

    def __init__(self, zones: Zones) -> None:
        self._sides, self._described = Sides(zones), zones.described()
        self._zones, self._lines = len(zones.zones), len(zones.lines)
        self._dwell_ns = np.array([round(1e9 * each.dwell_s) for each in zones.zones], np.int64)
        self._limit = np.array([each.limit for each in zones.zones], np.int64)
        self._lives = _blank(self._zones, self._lines)
        self._counts = np.zeros(self._zones, np.int64)
        self._stamp_ns = 0

    def memory(self) -> dict[str, Any]:
        """Return all that is known of tracks, as plain values; see `remember`."""
        lives = b64encode(self._lives.tobytes()).decode()
        return {'zones': self._described, 'stamp_ns': self._stamp_ns, 'lives': lives}

    def remember(self, memory: Mapping[str, Any]) -> None:
        """Go on with what another engine knew of tracks; if it had other zones, with nothing."""
        if memory['zones'] != self._described:
            return
        known = np.frombuffer(b64decode(memory['lives']), self._lives.dtype)
        self._lives, self._stamp_ns = known.copy(), int(memory['stamp_ns'])
        self._counts = (known['inside'] == 1).sum(axis=0)

    def added(self, tracks: Tracks, events: Events) -> Events:
        """Return fusion's events of a tick, and behind them its zone events; see `step`."""
        own = self.step(tracks, events)
        return Events.joined(events.stamp_ns, [events, own]) if len(own) else events

    def step(self, tracks: Tracks, events: Events) -> Events:
        """
        Return the zone events of a tick, by code, track and zone.

        Parameters
        ----------
        tracks : Tracks
            Of the tick.
        events : Events
            Of fusion in the tick; its corrections are used.

        """
        if not self._zones and not self._lines:
            return Events.build(tracks.stamp_ns)
        found: list[_Found] = []
        stamp_ns = tracks.stamp_ns
        if starts_anew(stamp_ns, self._stamp_ns):
            self._leave(np.arange(len(self._lives)), found)
            self._lives = _blank(self._zones, self._lines)
        self._stamp_ns = stamp_ns
        self._correct(events, found)
        self._follow(tracks, found)
        away = self._lives['seen_ns'] < stamp_ns - PAUSE_NS
        if away.any():
            self._leave(np.flatnonzero(away), found)
            self._lives = self._lives[self._lives['seen_ns'] >= stamp_ns - MEMORY_NS]
        self._count(found)
        return _events(stamp_ns, found)

    def _correct(self, events: Events, found: list[_Found]) -> None:
        """Move what is known of corrected tracks to their new ids, all at once."""
        (corrected,) = np.nonzero(events.event == EventCode.CORRECTION)
        if not len(corrected):
            return
        lives = self._lives
        old_ids, new_ids = events.old_id[corrected].tolist(), events.new_id[corrected].tolist()
        row_of = {int(each): row for row, each in enumerate(lives['track_id'])}
        rows = [row_of.pop(old_id, None) for old_id in old_ids]
        kept = np.ones(len(lives), bool)
        for row, new_id in zip(rows, new_ids):
            if row is None:
                continue
            if new_id in row_of:
                self._join(row_of[new_id], row, found)
                kept[row] = False
            else:
                lives['track_id'][row] = new_id
                row_of[new_id] = row
        self._lives = lives[kept]

    def _join(self, row: int, other: int, found: list[_Found]) -> None:
        """Join what is known of another track to that of a track which it turned out to be."""
        lives = self._lives
        last_ns = lives['last_ns'][row]
        (lines,) = np.nonzero((last_ns >= 0) & (last_ns < lives['first_ns'][other]))
        if len(lines):
            begin, end = lives['last'][row, lines], lives['first'][other, lines]
            ways = self._sides.crossed(begin, end, lines)
            for line, way, place in zip(lines.tolist(), ways.tolist(), end.tolist()):
                if way:
                    code = EventCode.CROSS_LEFT if way > 0 else EventCode.CROSS_RIGHT
                    zone, track_id = 1 + self._zones + line, int(lives['track_id'][row])
                    sure = float(self._sides.level[zone - 1])
                    found.append(_Found(code, track_id, zone, (*place, 0.0), sure))
        was_inside = (lives['inside'][row] == 1) | (lives['inside'][other] == 1)
        _merge(lives, row, other)
        for zone in np.flatnonzero(was_inside & (lives['inside'][row] != 1)).tolist():
            found.append(self._left(row, zone, float(self._sides.level[zone])))

    def _follow(self, tracks: Tracks, found: list[_Found]) -> None:
        """Note where the tracks of the tick are, and what happened to them since the last."""
        position = tracks.position[:, :2]
        kept = np.isfinite(position).all(axis=1) & np.isin(tracks.status, REPORTED)
        if not kept.any():
            return
        track_id, place = tracks.track_id[kept], position[kept].astype(np.float64)
        covariance = tracks.covariance[kept, :2, :2].astype(np.float64)
        rows = self._rows_of(track_id, place)
        lives = self._lives
        lives['seen_ns'][rows], lives['place'][rows] = self._stamp_ns, place
        look = self._sides.look(place, covariance)
        self._pass_boundaries(rows, look, found)
        self._cross(rows, place, look, found)

    def _rows_of(self, track_id: NDArray[np.uint32], place: NDArray[np.float64]) -> Rows:
        """Return the rows of tracks, which are made for those that are new."""
        lives = self._lives
        ordered = np.argsort(lives['track_id'])
        at = np.searchsorted(lives['track_id'], track_id, sorter=ordered)
        rows = ordered[np.minimum(at, len(ordered) - 1)] if len(ordered) else at
        is_new = np.ones(len(track_id), bool)
        if len(ordered):
            is_new = lives['track_id'][rows] != track_id
        if is_new.any():
            rows = rows.copy()
            rows[is_new] = len(lives) + np.arange(np.count_nonzero(is_new))
            self._lives = _extended(lives, track_id[is_new])
        return rows

    def _pass_boundaries(self, rows: Rows, look: Look, found: list[_Found]) -> None:
        """Decide who is in which zone; note who enters, leaves, dwells."""
        lives, zones = self._lives, slice(0, self._zones)
        before = lives['inside'][rows]
        is_sure = look.is_sure[:, zones]
        now = np.where(is_sure, look.inside, before).astype(np.int8)
        lives['inside'][rows] = now
        lives['decided_ns'][rows] = np.where(is_sure, self._stamp_ns, lives['decided_ns'][rows])
        entered, left = (now == 1) & (before != 1), (now == 0) & (before == 1)
        if entered.any():
            since_ns, dwelt = lives['since_ns'][rows], lives['dwelt'][rows]
            lives['since_ns'][rows] = np.where(entered, self._stamp_ns, since_ns)
            lives['dwelt'][rows] = dwelt & ~entered
        dwells = (now == 1) & (self._dwell_ns > 0) & ~lives['dwelt'][rows]
        dwells &= self._stamp_ns - lives['since_ns'][rows] >= self._dwell_ns
        if dwells.any():
            lives['dwelt'][rows] |= dwells
        for code, mask in (
            (EventCode.ENTER_ZONE, entered),
            (EventCode.LEAVE_ZONE, left),
            (EventCode.DWELL, dwells),
        ):
            self._note(code, rows, mask, look, found)

    def _cross(
        self, rows: Rows, place: NDArray[np.float64], look: Look, found: list[_Found]
    ) -> None:
        """Note who came from one side of a line to the other."""
        if not self._lines:
            return
        lives = self._lives
        is_sure = look.is_sure[:, self._zones :]
        last = lives['last'][rows]
        step = np.square(place[:, None] - last).sum(axis=2)  # NaN where none was sure before
        track, line = np.nonzero(is_sure & (step > look.squared[:, self._zones :]))
        if len(track):
            ways = np.zeros((len(rows), self._lines), np.int8)
            ways[track, line] = self._sides.crossed(last[track, line], place[track], line)
            for code, mask in (
                (EventCode.CROSS_LEFT, ways > 0),
                (EventCode.CROSS_RIGHT, ways < 0),
            ):
                self._note(code, rows, mask, look, found, self._zones)
        is_first = is_sure & (lives['first_ns'][rows] < 0)
        if is_first.any():
            track, line = np.nonzero(is_first)
            lives['first'][rows[track], line] = place[track]
            lives['first_ns'][rows[track], line] = self._stamp_ns
        lives['last'][rows] = np.where(is_sure[..., None], place[:, None], last)
        lives['last_ns'][rows] = np.where(is_sure, self._stamp_ns, lives['last_ns'][rows])

    def _note(
        self,
        code: EventCode,
        rows: Rows,
        mask: NDArray[np.bool_],
        look: Look,
        found: list[_Found],
        offset: int = 0,
    ) -> None:
        """Note an event for each track and zone, or line, of a mask."""
        track, shape = np.nonzero(mask)
        if not len(track):
            return
        sure = look.probability(track, shape + offset).tolist()
        lives = self._lives
        for row, zone, probability in zip(rows[track].tolist(), shape.tolist(), sure):
            x, y = lives['place'][row].tolist()
            track_id, index = int(lives['track_id'][row]), 1 + offset + zone
            found.append(_Found(code, track_id, index, (x, y, 0.0), probability))

    def _leave(self, rows: Rows, found: list[_Found]) -> None:
        """Note that tracks which ended are in no zone any more."""
        lives = self._lives
        for row, zone in zip(*(each.tolist() for each in np.nonzero(lives['inside'][rows] == 1))):
            found.append(self._left(int(rows[row]), zone, 0.0))
        lives['inside'][rows], lives['decided_ns'][rows] = -1, -1

    def _left(self, row: int, zone: int, probability: float) -> _Found:
        x, y = self._lives['place'][row].tolist()
        track_id = int(self._lives['track_id'][row])
        return _Found(EventCode.LEAVE_ZONE, track_id, 1 + zone, (x, y, 0.0), probability)

    def _count(self, found: list[_Found]) -> None:
        """Note in which zones there are more, or fewer, and which are crowded."""
        before, self._counts = self._counts, (self._lives['inside'] == 1).sum(axis=0)
        nowhere = (float('nan'),) * 3
        for zone in np.flatnonzero(self._counts != before).tolist():
            counts, limit = (int(before[zone]), int(self._counts[zone])), int(self._limit[zone])
            found.append(_Found(EventCode.OCCUPANCY, 0, 1 + zone, nowhere, 1.0, *counts))
            if counts[0] <= limit < counts[1] and limit:
                found.append(_Found(EventCode.CROWDED, 0, 1 + zone, nowhere, 1.0, *counts))


def _blank(zones: int, lines: int) -> Lives:
    """Return no tracks, and what is known of each at so many zones and lines."""
    return np.zeros(
        0,
        [
            ('track_id', np.int64),  # as it is called now
            ('seen_ns', np.int64),  # when it was reported last
            ('place', np.float64, (2,)),  # where, m
            ('inside', np.int8, (zones,)),  # 1 in a zone, 0 not, -1 not decided
            ('decided_ns', np.int64, (zones,)),  # when that was decided last, -1 never
            ('since_ns', np.int64, (zones,)),  # since when it is inside
            ('dwelt', np.bool_, (zones,)),  # whether an event said that it dwells
            ('first', np.float64, (lines, 2)),  # where it was clearly off a line first, m
            ('last', np.float64, (lines, 2)),  # where last
            ('first_ns', np.int64, (lines,)),  # when that was, -1 never
            ('last_ns', np.int64, (lines,)),
        ],
    )


def _extended(lives: Lives, track_id: NDArray[np.uint32]) -> Lives:
    """Return tracks and further ones of which nothing is known."""
    fresh = np.zeros(len(track_id), lives.dtype)
    fresh['track_id'] = track_id
    for name in ('inside', 'decided_ns', 'first_ns', 'last_ns'):
        fresh[name] = -1
    for name in ('first', 'last'):
        fresh[name] = np.nan
    return np.concatenate([lives, fresh])


def _merge(lives: Lives, row: int, other: int) -> None:
    """Join what is known of another track to that of one: what was decided last holds."""
    one, two = lives[row], lives[other].copy()
    both = (one['inside'] == 1) & (two['inside'] == 1)
    since_ns = np.minimum(one['since_ns'], two['since_ns'])
    dwelt = one['dwelt'] | two['dwelt']
    later = two['decided_ns'] >= one['decided_ns']
    for name in ('inside', 'decided_ns', 'since_ns', 'dwelt'):
        one[name][later] = two[name][later]
    one['since_ns'][both], one['dwelt'][both] = since_ns[both], dwelt[both]
    later = two['last_ns'] >= one['last_ns']
    earlier = two['first_ns'] >= 0
    earlier &= (one['first_ns'] < 0) | (two['first_ns'] < one['first_ns'])
    for name, mask in (('last', later), ('first', earlier)):
        one[name][mask] = two[name][mask]
        one[f'{name}_ns'][mask] = two[f'{name}_ns'][mask]
    if two['seen_ns'] > one['seen_ns']:
        one['seen_ns'], one['place'] = two['seen_ns'], two['place']


def _events(stamp_ns: int, found: list[_Found]) -> Events:
    """Return what was found as events, in their order."""
    if not found:
        return Events.build(stamp_ns)
    found.sort(key=lambda each: each[:3])
    return Events.build(
        stamp_ns,
        position=[each.position for each in found],
        probability=[each.probability for each in found],
        track_id=[each.track_id for each in found],
        old_id=[each.old_id for each in found],
        new_id=[each.new_id for each in found],
        zone=[each.zone for each in found],
        event=[each.event for each in found],
    )
