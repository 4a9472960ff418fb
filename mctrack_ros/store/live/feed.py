"""Messages of a spool into a database, run after run."""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import select

from mctrack_ros.codec import further_fields, rows_from_cloud
from mctrack_ros.interfaces import Tracks, starts_anew
from mctrack_ros.recording.bags.definitions import TYPES
from mctrack_ros.recording.bags.site_topic import SITE_TOPIC
from mctrack_ros.store.bags import kind_of
from mctrack_ros.store.database import Database
from mctrack_ros.store.live.spool import Record, Spool
from mctrack_ros.store.runs import NewRun, find_progress, free_name
from mctrack_ros.store.schema import DESCRIPTIONS
from mctrack_ros.store.writer import TrajectoryWriter

_CLOUD, _TEXT = 'sensor_msgs/msg/PointCloud2', 'std_msgs/msg/String'


@dataclass(frozen=True, slots=True)
class FeedOptions:
    """
    How runs are called.

    Attributes
    ----------
    run : str
        Name of the first run, numbered from the second on; none: as `/site` says.
    site : str
        Name of the site.
    finish : bool
        Whether the run is finished at the end: nothing is written into it any more.

    """

    run: str = ''
    site: str = 'site'
    finish: bool = False


@dataclass(slots=True)
class FeedState:
    """
    What a feed has done, for those who watch it.

    Attributes
    ----------
    written, refused : int
        Messages that are in the database, and that could not be used.
    run : str
        Name of the run that is written.
    said : deque of str
        What a user should know; who shows it takes it out.

    """

    written: int = 0
    refused: int = 0
    run: str = ''
    said: deque[str] = field(default_factory=deque)


class Feed:
    """
    Write what a spool holds into a database.

    A run ends when `/site` names another one or time steps back by a second; what follows is
    another run. How far the spool is written is kept in the same transaction, so that nothing is
    written twice, whoever died in between.

    Parameters
    ----------
    database : Database
        Where it is written.
    spool : Spool
        What is written.
    options : FeedOptions
        How runs are called.
    state : FeedState
        Told what is done.

    Raises
    ------
    StoreError
        If the database refuses; `write` does, too: then another feed goes on where it was.

    """

    def __init__(
        self, database: Database, spool: Spool, options: FeedOptions, state: FeedState
    ) -> None:
        self._database, self._spool = database, spool
        self._options, self._state = options, state
        self._writer: TrajectoryWriter | None = None
        self._frame_id = ''
        self._site = ''
        self._site_of_run = ''
        self._looked_at: set[str] = set()
        self._take_up()

    def write(self) -> None:
        """Write all that the spool holds."""
        while records := self._spool.read():
            count = 0
            for record in records:
                count += self._write(record)
            if self._writer is not None:
                self._writer.flush()
            self._spool.free(self._position)
            self._state.written += count

    def close(self) -> None:
        """Finish the run if it is to be; else it can be continued."""
        if self._writer is not None and self._options.finish:
            self._writer.close()

    def _take_up(self) -> None:
        """Continue the run into which the last message of the spool was written."""
        with self._database.connected() as connection:
            self._position, run = find_progress(connection, self._spool.source)
            if run is not None and run.ended_ns is None:
                asked = select(DESCRIPTIONS.c.text).where(DESCRIPTIONS.c.run_id == run.run_id)
                last = asked.order_by(DESCRIPTIONS.c.number.desc()).limit(1)
                self._site = self._site_of_run = connection.execute(last).scalar() or ''
        self._spool.rewind(self._position)
        if run is not None and run.ended_ns is None:
            self._frame_id = run.frame_id
            self._open(run.name, (), resume=True)
        elif run is not None:
            self._state.said.append(f'run {run.name} is finished: another one begins')
        elif self._position:
            self._state.said.append('the run that was written is gone: another one begins')

    def _write(self, record: Record) -> bool:
        """Write a message, unless it is in the database already; tell whether it is written."""
        if record.topic == SITE_TOPIC and record.number <= self._position:
            self._site = _text_of(record)
            return False
        self._position = record.number
        if self._writer is not None:
            self._writer.position = record.number
        if record.topic == SITE_TOPIC:
            return self._write_site(record)
        try:
            rows, frame_id = self._rows(record)
        except Exception as error:  # whatever a stranger sent
            return self._refuse(record, str(error))
        if isinstance(rows, Tracks):
            return self._write_tracks(record, rows, frame_id)
        writer = self._writer or self._begin(record, frame_id)
        if frame_id != self._frame_id:
            return self._refuse(record, f'it is in the frame {frame_id}, not {self._frame_id}')
        writer.write_events(rows, record.topic, record.log_ns)
        return True

    def _rows(self, record: Record) -> tuple[Any, str]:
        """Return what a message holds and its frame; say once of each topic what is not stored."""
        kind = kind_of(record.topic)
        message: Any = TYPES.deserialize_cdr(memoryview(record.data), _CLOUD)
        rows = rows_from_cloud(message, kind)
        if record.topic not in self._looked_at:
            self._looked_at.add(record.topic)
            if further := further_fields(message, kind):
                self._state.said.append(f'{record.topic}: not stored: {", ".join(further)}')
        return rows, str(message.header.frame_id)

    def _write_tracks(self, record: Record, rows: Tracks, frame_id: str) -> bool:
        last_ns = None if self._writer is None else self._writer.last_ns
        if self._writer is None:
            self._begin(record, frame_id)
        elif starts_anew(rows.stamp_ns, last_ns):
            self._end(f'time steps back from {last_ns} to {rows.stamp_ns} ns')
            self._begin(record, frame_id)
        elif frame_id != self._frame_id:
            return self._refuse(record, f'it is in the frame {frame_id}, not {self._frame_id}')
        elif last_ns is not None and rows.stamp_ns <= last_ns:
            return self._refuse(
                record, f'its stamp, {rows.stamp_ns} ns, is not after the last one'
            )
        assert self._writer is not None
        self._writer.write_tracks(rows, record.log_ns)
        return True

    def _write_site(self, record: Record) -> bool:
        """Write what `/site` says; another run than that which is written ends that one."""
        try:
            text = _text_of(record)
            said = _said(text)
        except Exception as error:  # whatever a stranger sent
            return self._refuse(record, str(error))
        known, self._site = self._site, text
        if self._writer is None or text == known == self._site_of_run:
            return False
        if said.get('run') == _said(self._site_of_run).get('run') and self._site_of_run:
            self._writer.write_description(text, record.log_ns)
            self._site_of_run = text
            return True
        self._end(f'/site names run {said.get("run")}')
        return False

    def _end(self, reason: str) -> None:
        """Finish the run."""
        assert self._writer is not None
        self._writer.position = self._position - 1
        self._writer.close()
        self._state.said.append(f'run {self._state.run} is finished: {reason}')
        self._writer = None

    def _begin(self, record: Record, frame_id: str) -> TrajectoryWriter:
        """Begin a run with a message."""
        said = _said(self._site)
        wanted = self._options.run or str(said.get('run') or f'run-{record.log_ns}')
        with self._database.connected() as connection:
            name = free_name(connection, wanted)
        self._frame_id = frame_id
        writer = self._open(name, tuple(map(str, said.get('cameras') or ())), resume=True)
        if self._site:
            writer.write_description(self._site, record.log_ns)
        self._site_of_run = self._site
        return writer

    def _open(self, name: str, cameras: tuple[str, ...], *, resume: bool) -> TrajectoryWriter:
        run = NewRun(name, self._options.site, cameras, self._frame_id)
        source = self._spool.source
        self._writer = TrajectoryWriter(self._database, run, resume=resume, source=source)
        self._writer.position = self._position
        self._state.run = name
        self._state.said.append(f'writes run {name}')
        return self._writer

    def _refuse(self, record: Record, reason: str) -> bool:
        """Count a message that cannot be used, and say the first of each topic."""
        self._state.refused += 1
        if f'{record.topic} refused' not in self._looked_at:
            self._looked_at.add(f'{record.topic} refused')
            self._state.said.append(f'{record.topic} refused: {reason}')
        return False


def _text_of(record: Record) -> str:
    message: Any = TYPES.deserialize_cdr(record.data, _TEXT)
    return str(message.data)


def _said(site: str) -> dict[str, Any]:
    """Return what a text of `/site` holds; raises `ValueError`."""
    return dict(json.loads(site or '{}'))
