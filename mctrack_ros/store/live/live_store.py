"""What comes now into a database, without waiting for it."""

from __future__ import annotations

import threading
import time
import traceback
from pathlib import Path

from sqlalchemy import URL

from mctrack_ros.recording.bags.site_topic import SITE_TOPIC
from mctrack_ros.recording.closing import Closing
from mctrack_ros.store.database import Database, url_of
from mctrack_ros.store.errors import StoreError
from mctrack_ros.store.live.feed import Feed, FeedOptions, FeedState
from mctrack_ros.store.live.spool import Spool
from mctrack_ros.store.upkeep.retention import Keep, forget_old
from mctrack_ros.store.writer import FLUSH_S

_SAVE_S = 0.1
"""Most that is lost if the process is killed: what the system holds outlives it."""
_LONGEST_PAUSE_S = 5.0
_FORGET_S = 3600.0
"""How often what is too old is deleted."""
_PATIENCE_S = 4.0
"""For what waits, at the end; what is not written by then stays in the spool."""


class LiveStore(Closing):
    """
    Keep the messages of a running graph in a database.

    What comes is saved in a spool every tenth of a second, synchronised with the disk every half
    second, and written into the database by a thread of its own. While the database is away, the
    spool grows up to a limit; when it is back, it catches up.

    Parameters
    ----------
    place : str or Path
        The database, made unless it is there.
    folder : Path
        Of the spool.
    limit : int
        Bytes of the spool.
    options : FeedOptions
        How runs are called.
    keep : Keep, optional
        How long each kind of data is kept; older is deleted every hour.

    Attributes
    ----------
    state : FeedState
        What was done.
    failure : str
        Why the database takes nothing; empty: it does.

    Raises
    ------
    StoreError
        If the place is none, or the spool cannot be used.

    """

    def __init__(
        self,
        place: str | Path,
        folder: Path,
        limit: int,
        options: FeedOptions,
        keep: Keep | None = None,
    ) -> None:
        _make_folder(url_of(place))
        self.spool = Spool(folder, limit, SITE_TOPIC)
        self.state, self.failure = FeedState(), ''
        self._place, self._options, self._keep = place, options, keep or Keep()
        self._forgotten_s = -_FORGET_S
        self._written_s = time.monotonic()
        self._ending = threading.Event()
        self._threads = [
            threading.Thread(target=each, daemon=True, name=name)
            for each, name in ((self._save, 'spool'), (self._write, 'database'))
        ]
        for thread in self._threads:
            thread.start()

    def put(self, topic: str, log_ns: int, data: bytes) -> None:
        """
        Take a message.

        Parameters
        ----------
        topic : str
            ``/site``, ``/tracks`` or one of events.
        log_ns : int
            When it came, ns.
        data : bytes
            As it was serialised.

        """
        self.spool.put(topic, log_ns, data)

    def close(self) -> None:
        """Write what waits, if the database takes it soon; the rest stays in the spool."""
        self._ending.set()
        until_s = time.monotonic() + _PATIENCE_S
        for thread in self._threads:
            thread.join(max(until_s - time.monotonic(), 0.0))
        if not self._threads[0].is_alive():
            self.spool.close()

    @property
    def behind_s(self) -> float:
        """Time since all that had come was in the database, s."""
        return time.monotonic() - self._written_s

    def _save(self) -> None:
        synchronised_s = time.monotonic()
        while not self._ending.wait(_SAVE_S):
            self.spool.save()
            if time.monotonic() - synchronised_s >= FLUSH_S:
                synchronised_s = time.monotonic()
                self.spool.synchronise()
        self.spool.save()

    def _write(self) -> None:
        pause_s = FLUSH_S
        while not self._ending.is_set():
            try:
                with Database(self._place, create=True) as database:
                    feed = Feed(database, self.spool, self._options, self.state)
                    while True:
                        is_last = self._ending.wait(FLUSH_S)
                        if is_last:
                            self._threads[0].join()
                        feed.write()
                        self._forget(database)
                        self.failure, pause_s = '', FLUSH_S
                        self._written_s = time.monotonic()
                        if is_last:
                            feed.close()
                            return
            except StoreError as error:
                self._fail(str(error))
            except Exception:  # a mistake: what waits is safe, and written again
                self._fail(traceback.format_exc())
            self._ending.wait(pause_s)
            pause_s = min(2 * pause_s, _LONGEST_PAUSE_S)

    def _forget(self, database: Database) -> None:
        """Delete what is old, now and then."""
        if self._keep == Keep() or time.monotonic() - self._forgotten_s < _FORGET_S:
            return
        self._forgotten_s = time.monotonic()
        forgotten = forget_old(database, self._keep, time.time_ns())
        if any(forgotten.values()):
            counts = ', '.join(f'{count} {kind}' for kind, count in forgotten.items())
            self.state.said.append(f'deleted what is too old: {counts}')

    def _fail(self, reason: str) -> None:
        if not self.failure:
            self.state.said.append(f'the database takes nothing, the spool does: {reason}')
        self.failure = reason


def _make_folder(url: URL) -> None:
    """Make the folder of a file."""
    if url.get_backend_name() == 'sqlite' and url.database:
        Path(url.database).parent.mkdir(parents=True, exist_ok=True)
