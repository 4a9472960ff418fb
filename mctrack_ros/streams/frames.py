"""What a stream is made of: the tracks of a tick with the events up to it."""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from mctrack_ros.input_size import SITE
from mctrack_ros.interfaces import EventCode, Events, Tracks, TrackStatus


@dataclass(frozen=True, slots=True)
class About:
    """
    What is said once of a stream.

    Attributes
    ----------
    run : str
        Run of the tracker: ids mean the same within it.
    frame_id : str
        Frame of the positions.
    origin : (float, float)
        Origin of the positions in the coordinates of the site's files, m.
    lost_ns : int
        For how long somebody who was lost may be found again under his id, ns.
    zones : tuple of str
        Names of the zones and lines, in the order of their indices, which begin at 1.

    """

    run: str = ''
    frame_id: str = 'map'
    origin: tuple[float, float] = (0.0, 0.0)
    lost_ns: int = 0
    zones: tuple[str, ...] = ()

    @classmethod
    def of_site(cls, text: str, frame_id: str, run: str = '') -> Self:
        """
        Read what `/site` says; a run given by name keeps it.

        Raises
        ------
        ValueError
            If it is no description of a site.

        """
        if len(text) > SITE:
            raise ValueError(f'/site holds {len(text)} characters, expected at most {SITE}')
        try:
            said: Mapping[str, Any] = json.loads(text)
            x, y = said['origin']
            lost_s = said['fusion'].get('reid', {}).get('lost_time', 0.0)
            return cls(
                run or str(said['run']),
                frame_id,
                (float(x), float(y)),
                round(float(lost_s) * 1e9),
                tuple(str(zone['name']) for zone in said.get('zones', ())),
            )
        except (TypeError, KeyError, AttributeError, ValueError) as error:
            raise ValueError(f'/site holds no description of a site: {error!r}') from error


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """
    A tick.

    Attributes
    ----------
    tracks : Tracks
        Of the tick.
    events : tuple of Events
        Messages of events of this tick, and of earlier ones that came late.
    before : Tracks
        Of the tick before.
    forgotten : tuple of int
        Ids that will not come back: their tracks ended, and nobody was found again under them.
    zones : tuple of str
        Names of the zones and lines, in the order of their indices, which begin at 1.

    """

    tracks: Tracks
    events: tuple[Events, ...]
    before: Tracks
    forgotten: tuple[int, ...] = ()
    zones: tuple[str, ...] = ()

    def zone_name(self, index: int) -> str:
        """Return the name of a zone or line; empty: it is not known."""
        return self.zones[index - 1] if 0 < index <= len(self.zones) else ''

    @property
    def stamp_ns(self) -> int:
        """Stamp of the tick, ns."""
        return self.tracks.stamp_ns


class Assembler:
    """
    Put messages of `/tracks` and `/events` together to frames.

    Parameters
    ----------
    about : About
        What they are of.

    """

    def __init__(self, about: About) -> None:
        self.about = about
        self._before = Tracks.build(0)
        self._tracks: Tracks | None = None
        self._events: list[Events] = []
        self._late: list[Events] = []
        self._ended: dict[int, int] = {}

    @property
    def stamp_ns(self) -> int | None:
        """Stamp of the frame that was begun, ns; None: there is none."""
        return None if self._tracks is None else self._tracks.stamp_ns

    def add_tracks(self, tracks: Tracks) -> Frame | None:
        """Begin a frame; return the one before, unless it was finished."""
        frame = self.finish()
        self._tracks = tracks
        return frame

    def add_events(self, events: Events) -> None:
        """Add events to the frame that was begun, or to the next one if they are later."""
        of_this = self._tracks is not None and events.stamp_ns <= self._tracks.stamp_ns
        (self._events if of_this else self._late).append(events)

    def finish(self) -> Frame | None:
        """Return the frame that was begun; None: there is none."""
        tracks, self._tracks = self._tracks, None
        if tracks is None:
            return None
        if tracks.stamp_ns < self._before.stamp_ns:  # time begins anew, and so do ids
            self._before, self._ended = Tracks.build(0), {}
        self._late.sort(key=lambda events: events.stamp_ns)
        count = bisect_right(self._late, tracks.stamp_ns, key=lambda events: events.stamp_ns)
        events = (*self._late[:count], *self._events)
        del self._late[:count]
        frame = Frame(tracks, events, self._before, self._forget(tracks, events), self.about.zones)
        self._before, self._events = tracks, []
        return frame

    def _forget(self, tracks: Tracks, events: Sequence[Events]) -> tuple[int, ...]:
        """Return the ids that have been gone for so long that they will not come back."""
        for each in events:
            for track in each.track_id[each.event == EventCode.EXIT].tolist():
                self._ended.setdefault(track, tracks.stamp_ns)
        if not self._ended:
            return ()
        for track in tracks.track_id[tracks.status != TrackStatus.DELETED].tolist():
            self._ended.pop(track, None)
        over_ns = tracks.stamp_ns - self.about.lost_ns
        over = [track for track, ended_ns in self._ended.items() if ended_ns <= over_ns]
        for track in over:
            del self._ended[track]
        return tuple(over)


def groups_of(tracks: Tracks) -> dict[int, list[int]]:
    """Return the members of each group, by its id, which is that of one of them."""
    named = np.unique(tracks.group[tracks.group > 0]).tolist()
    belongs = tracks.status != TrackStatus.DELETED
    return {
        group: tracks.track_id[
            belongs & ((tracks.group == group) | (tracks.track_id == group))
        ].tolist()
        for group in named
    }
