"""A bag replayed in lock step, and its tracks compared with those that were recorded."""

from __future__ import annotations

import tempfile
from base64 import b64decode
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mctrack_ros.codec import ros_from_message, rows_from_cloud, stamp_ns_of
from mctrack_ros.fusion import FusionConfig, OpenViews, Startable, open_fusion
from mctrack_ros.fusion.trackers import START_TOPIC, FusionTracker, no_views
from mctrack_ros.interfaces import Detections, RowsTick, Tracks
from mctrack_ros.recording import ROSBAGS_CLASSES, BagError, BagReader, attachments
from mctrack_ros.recording.track_log.log import (
    EMPTY,
    TRACKS,
    Canonical,
    StoredLog,
    chained,
    cloud_fields,
)
from mctrack_ros.recording.track_log.provenance import differences, provenance
from mctrack_ros.replay.lockstep import ReplayError
from mctrack_ros.replay.proof.difference import Difference, first_difference, largest_difference
from mctrack_ros.replay.proof.state import dump_state, go_on_with, restore_state, stated
from mctrack_ros.replay.recorded import (
    ALWAYS,
    Span,
    recorded_runs,
    recorded_settings,
    recorded_ticks,
    settings_of,
)
from mctrack_ros.site.description import STATE
from mctrack_ros.site.portable import unpack_site
from mctrack_ros.site.site import SiteConfig, load_site

_AHEAD = 50
"""Number of recorded messages that are looked through for the tracks of a tick."""


@dataclass(frozen=True, slots=True)
class Changed:
    """
    A message that is not what was written.

    Attributes
    ----------
    topic, field : str
        Where, and the first field that differs; ``message``: it is no cloud.
    stamp_ns : int
        Its stamp, ns.

    """

    topic: str
    field: str
    stamp_ns: int


@dataclass(slots=True)
class ReplayCheck:
    """
    What a replay gave.

    Attributes
    ----------
    ticks : int
        How many were fused.
    first_ns, last_ns : int
        Stamps of the first and the last one, ns.
    digest : bytes
        SHA-256 of the log of tracks.
    stored : bytes, optional
        The same as it was when the bag was finished, if the bag says so of these ticks.
    lacking : int
        Of how many ticks tracks were written that cannot be replayed any more.
    compared : int
        Of how many ticks the bag holds the tracks.
    first, largest : Difference, optional
        Where these differ first, and most.
    other_ids : int
        Ticks in which they have other ids.
    changed : list of Changed
        The first message of each topic that is not what was written.
    made_elsewhere : list of str
        What differs between the versions and processors.
    began_late : bool
        Whether the first tick recorded has tracks that are older.
    failure : str
        Why a bag with changed messages could not be replayed to its end.

    """

    ticks: int = 0
    first_ns: int = 0
    last_ns: int = 0
    digest: bytes = EMPTY
    stored: bytes | None = None
    lacking: int = 0
    compared: int = 0
    first: Difference | None = None
    largest: Difference | None = None
    other_ids: int = 0
    changed: list[Changed] = field(default_factory=list)
    made_elsewhere: list[str] = field(default_factory=list)
    began_late: bool = False
    failure: str = ''

    @property
    def seconds(self) -> float:
        """Time from the first tick to the last, s."""
        return (self.last_ns - self.first_ns) * 1e-9

    @property
    def is_same(self) -> bool:
        """Whether the tracks are those that were recorded, and all messages what was written."""
        return self.has_same_tracks and not self.changed

    @property
    def is_compared(self) -> bool:
        """Whether the bag says what the tracks were."""
        return bool(self.compared or self.stored)

    @property
    def has_same_tracks(self) -> bool:
        """Whether the tracks are those that were recorded."""
        is_stored = self.stored in (None, self.digest)
        return self.first is None and is_stored and not self.lacking

    @property
    def is_fault(self) -> bool:
        """Whether the replay had to give the same and did not, or nobody knows."""
        if not self.is_compared:
            return True
        return not self.is_same and not (self.made_elsewhere and not self.changed)

    def line(self) -> str:
        """Say it in one line."""
        length = f'{self.ticks} ticks, {self.seconds:.3f} s'
        if self.is_same:
            known = 'as stored' if self.stored else f'as the tracks of {self.compared} ticks'
            if not self.is_compared:
                return f'not compared, the bag holds no tracks: {length}, {self.digest.hex()}'
            return f'same: {length}, track log {self.digest.hex()} {known}'
        if not self.is_fault:
            texts = ['not the same, as versions or processors differ']
            texts += (
                [f'largest difference {self._described(self.largest)}'] if self.largest else []
            )
            texts.append(f'other ids in {self.other_ids} ticks')
            return '; '.join([*texts, *self.made_elsewhere])
        parts = [f'{self._described(self.first)} first'] if self.first else []
        if self.lacking:
            parts.append(f'the bag lacks {self.lacking} ticks whose tracks were written')
        elif self.first is None and not self.has_same_tracks and not self.changed:
            parts.append('the bag lacks tracks that were written')
        parts += [
            f'{each.field} of {each.topic} at {self._since(each.stamp_ns)} is not what was written'
            for each in self.changed
        ]
        if self.failure:
            parts.append(f'it ends there: {self.failure}')
        if self.began_late:
            parts.append('the recording began after the tracking')
        return f'differs: {"; ".join(parts)} ({length})'

    def _described(self, found: Difference) -> str:
        who = f' of track {found.track_id}' if found.track_id else ''
        size = f' ({found.size:.3g})' if found.size > 0 else ''
        return (
            f'tick {found.tick} at {self._since(found.stamp_ns)}, {found.field}{who}: '
            f'recorded {found.there}, replayed {found.here}{size}'
        )

    def _since(self, stamp_ns: int) -> str:
        return f'{(stamp_ns - self.first_ns) * 1e-9:.3f} s'


@dataclass(slots=True)
class Replay:
    """
    How a bag is replayed.

    Attributes
    ----------
    site : SiteConfig, optional
        Cameras and settings; unless given, those that the bag carries.
    namespace : str
        Where the topics lie in the bag.
    state : bytes, optional
        Of a tracker, as `dump_state` returns it: the replay goes on behind it.
    until_s : float, optional
        Time since the first tick after which it ends, s.

    """

    site: SiteConfig | None = None
    namespace: str = ''
    state: bytes | None = None
    until_s: float | None = None


def verify_bag(bag: str | Path, how: Replay | None = None) -> tuple[ReplayCheck, bytes]:
    """
    Fuse the recorded detections of a bag again, and compare.

    What is fused is what ``/ticks`` says was admitted; without it, all.

    Parameters
    ----------
    bag : str or Path
        A recorded bag, or the folder that `track_bag` writes.
    how : Replay, optional
        How it is replayed.

    Returns
    -------
    check : ReplayCheck
        What came of it.
    state : bytes
        Of the tracker after the last tick.

    Raises
    ------
    BagError, CalibrationError, ConfigError, ReplayError, StateError
        If the bag cannot be replayed.

    """
    how, path = how or Replay(), _bag_in(Path(bag))
    attached = attachments(path)
    stored = StoredLog.of(attached)
    with tempfile.TemporaryDirectory(prefix='mctrack_') as folder:
        given, place = how.site, unpack_site(attached, Path(folder))
        carried = load_site(place) if given is None and place is not None else given
        with BagReader(path, how.namespace) as reader:
            run = _Run(reader, how, carried)
            run.check.changed = _changed(reader, how.namespace, stored)
            try:
                for index, (said, span) in enumerate(recorded_runs(reader) or [({}, ALWAYS)]):
                    run.replay(index, said, span)
            except (BagError, ValueError, OverflowError) as error:
                if not run.check.changed:
                    raise
                run.check.failure = str(error)
    check = run.check
    if not (check.ticks or check.failure):
        raise ReplayError(f'{path} has no tick to replay')
    count, digest = stored.hashes.get(f'{how.namespace}{TRACKS}', (0, EMPTY))
    check.stored = digest if count == run.number else None
    if how.until_s is None:
        check.lacking = max(count - run.number - run.earlier, 0)
    made_by: Mapping[str, str] = run.made_by or stored.made_by
    check.made_elsewhere = differences(made_by, provenance())
    return check, run.state()


class _Run:
    """
    Replays the runs of fusion in a bag, one after another.

    Attributes
    ----------
    check : ReplayCheck
        What came of it so far.
    number : int
        Ticks since the bag's first one.
    made_by : mapping
        Versions and processor of the first run, if the bag says.

    """

    def __init__(self, reader: BagReader, how: Replay, site: SiteConfig | None) -> None:
        self.check, self.number = ReplayCheck(), 0
        self.made_by: Mapping[str, str] = {}
        self._reader, self._how, self._site = reader, how, site
        self._begin_ns: int | None = None
        self._behind = stated(how.state) if how.state else {}
        self._tracker: FusionTracker | None = None
        self._run = 0
        self._recorded = _Recorded(reader)

    @property
    def earlier(self) -> int:
        """How many ticks have tracks from before the first one that can be replayed."""
        return self._recorded.earlier or 0

    def replay(self, index: int, said: Mapping[str, Any], span: Span) -> None:
        """Replay one run, which has a number from 0."""
        self.made_by = self.made_by or said.get('made_by', {})
        cameras, config = self._settings(said)
        tracker = open_fusion(config, cameras, int(said.get('first_id', 1)), self._views())
        if STATE in said:
            go_on_with(tracker, b64decode(said[STATE]), int(said['first_id']))
        topic = f'/{START_TOPIC}'
        if isinstance(tracker, Startable) and self._reader.count(topic):
            for rows, _ in self._reader.rows(topic, Detections, *span):
                tracker.start(rows)
        if self._how.state is not None and index == self._behind['run']:
            restore_state(tracker, self._how.state)
            self.check.digest = bytes.fromhex(self._behind['digest'])
        for tick in recorded_ticks(self._reader, cameras, config, span):
            self.number += 1
            if self._begin_ns is None:
                self._begin_ns = self.check.first_ns = tick.stamp_ns
            if self.number <= self._behind.get('number', 0):
                self._recorded.tracks(tick.stamp_ns)
                continue
            if self._how.until_s is not None and self._is_over(tick):
                self.number -= 1
                return
            self._tracker, self._run = tracker, index
            self._compare(tick, tracker.step(tick).tracks)

    def state(self) -> bytes:
        """Return the state of the tracker after the last tick; nothing if there was none."""
        if self._tracker is None:
            return b''
        digest = self.check.digest.hex()
        said = {'run': self._run, 'number': self.number, 'digest': digest}
        return dump_state(self._tracker, said)

    def _settings(self, said: Mapping[str, Any]) -> tuple[tuple[str, ...], FusionConfig]:
        if self._how.site is None and 'fusion' in said:
            return settings_of(said)
        return recorded_settings(self._reader, self._site)

    def _views(self) -> OpenViews:
        return no_views if self._site is None else self._site.views

    def _is_over(self, tick: RowsTick[Any]) -> bool:
        assert self._begin_ns is not None
        assert self._how.until_s is not None
        return (tick.stamp_ns - self._begin_ns) * 1e-9 > self._how.until_s

    def _compare(self, tick: RowsTick[Any], tracks: Tracks) -> None:
        """Add a tick's tracks to the log, and hold them against the recorded ones."""
        check = self.check
        check.ticks += 1
        check.last_ns = tick.stamp_ns
        message = ros_from_message(tracks, ROSBAGS_CLASSES, '')
        fields = cloud_fields(message)
        check.digest = chained(check.digest, tracks.stamp_ns, fields)
        recorded = self._recorded.tracks(tracks.stamp_ns)
        if recorded is None:
            return
        check.compared += 1
        there = cloud_fields(recorded)
        if self.number == 1:
            check.began_late = bool(rows_from_cloud(recorded, Tracks).age.max(initial=0.0) > 0)
        if there != fields:
            self._note_difference(recorded, message)
            check.other_ids += there.get('track_id') != fields['track_id']

    def _note_difference(self, recorded: Any, message: Any) -> None:
        """Keep the first difference of all ticks, and the largest."""
        check, number = self.check, self.number - 1
        check.first = check.first or first_difference(number, recorded, message)
        most = largest_difference(number, recorded, message)
        if most and (check.largest is None or most.size > check.largest.size):
            check.largest = most


class _Recorded:
    """
    The tracks of a bag, found by their stamps in the order of recording.

    Attributes
    ----------
    earlier : int, optional
        How many are older than the first that was asked for; None: none was yet.

    """

    def __init__(self, reader: BagReader) -> None:
        has_tracks = reader.count(TRACKS)
        self._messages: Iterator[Any] = reader.messages([TRACKS]) if has_tracks else iter(())
        self._waiting: dict[int, Any] = {}
        self.earlier: int | None = None

    def tracks(self, stamp_ns: int) -> Any:
        """Return the message of a tick, None: it was not recorded; earlier ones are let go."""
        while stamp_ns not in self._waiting and len(self._waiting) < _AHEAD:
            found = next(self._messages, None)
            if found is None:
                break
            self._waiting[stamp_ns_of(found[1])] = found[1]
        if self.earlier is None:
            self.earlier = sum(each < stamp_ns for each in self._waiting)
        message = self._waiting.pop(stamp_ns, None)
        if message is not None:
            self._waiting = {each: kept for each, kept in self._waiting.items() if each > stamp_ns}
        return message


def _changed(reader: BagReader, namespace: str, stored: StoredLog) -> list[Changed]:
    """Return the first message of each topic that is not what was written."""
    found: dict[str, Changed] = {}
    for topic, kind, data, time_ns in reader.serialized() if stored.checksums else ():
        if topic in found:
            continue
        message, full = Canonical.of(kind, data, time_ns), f'{namespace}{topic}'
        full = full if full in stored.checksums else topic
        name = stored.changed_field(full, time_ns, message)
        if name:
            found[topic] = Changed(topic, name, message.stamp_ns)
    return sorted(found.values(), key=lambda each: each.stamp_ns)


def _bag_in(path: Path) -> Path:
    """Return the bag that a path names: itself, or that in the folder of a tracked run."""
    inside = path / 'bag'
    return inside if (inside / 'metadata.yaml').exists() else path
