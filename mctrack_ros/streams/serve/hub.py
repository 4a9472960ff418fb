"""One source, many readers: a bounded memory of frames, a bounded queue a reader."""

from __future__ import annotations

import asyncio
from bisect import bisect_right
from collections import deque
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from typing import Protocol

from mctrack_ros.store.errors import StoreError
from mctrack_ros.streams.formats.profiles import Profile
from mctrack_ros.streams.frames import About, Frame
from mctrack_ros.streams.serve.packing import Block, SharedPacker

MOST_WAITING = 100
"""Frames that may wait for a reader; with more, 4 s at 25 Hz, he is dropped."""
STUCK_S = 10.0
"""Time that a reader of the past may take for a frame of it, s."""
UNKNOWN_S = 3.0
"""Time that a reader waits to be told which run it is, s."""
MOST_REMEMBERED = 20_000
"""Frames, whatever the time that the memory is to reach back."""
_LATEST_NS = 2**63 - 1
_AT_ONCE = 4
"""Remembered frames that one reader is sent before others have their turn."""


class Past(Protocol):
    """Frames of a run that are no longer remembered, one reader's."""

    def next(self, after_ns: int, before_ns: int) -> Sequence[Frame]:
        """Return the next frames after a stamp and before another, ns; empty: no more."""
        ...


History = Callable[[About, int], Past]
"""Opens the past of a run from a stamp on, ns."""


@dataclass(slots=True)
class Entry:
    """A frame, with its text in each form that somebody asked for."""

    frame: Frame
    texts: dict[str, bytes] = field(default_factory=dict)

    def text(self, profile: Profile) -> bytes:
        """Return its text in a form."""
        if profile.name not in self.texts:
            self.texts[profile.name] = profile.frame(self.frame).encode()
        return self.texts[profile.name]


class Reader:
    """
    One who reads: frames wait for him, as many as he may be behind.

    Parameters
    ----------
    profile : Profile
        The form.
    about : About
        What is said first.
    drop : callable
        Ends his connection at once, whatever he has not read.

    Attributes
    ----------
    is_live, is_over : bool
        Whether he is sent what comes; whether the stream ends.
    began_s : float or None
        Since when he is being sent a frame of the past, in the loop's time, s; None: he is not.

    """

    def __init__(self, profile: Profile, about: About, drop: Callable[[], None]) -> None:
        self.profile, self.about = profile, about
        self._drop = drop
        self._waiting: deque[Block] = deque()
        self._news = asyncio.Event()
        self._is_dropped = False
        self.is_live = self.is_over = False
        self.began_s: float | None = None

    def offer(self, block: Block) -> None:
        """Let a block wait for him; if too many do, drop him."""
        if len(self._waiting) >= MOST_WAITING:
            self.drop()
            return
        self._waiting.append(block)
        self._news.set()

    def drop_if_stuck(self, now_s: float) -> None:
        """Drop him if he does not read of the past what he asked for."""
        if self.began_s is not None and now_s - self.began_s > STUCK_S:
            self.drop()

    def drop(self) -> None:
        """End his connection at once."""
        self.end()
        self._waiting.clear()
        if not self._is_dropped:
            self._is_dropped = True
            self._drop()

    def end(self) -> None:
        """Let the stream end with what waits."""
        self.is_over = True
        self._news.set()

    async def blocks(self) -> AsyncIterator[Block]:
        """Yield what comes, until the end."""
        while True:
            while self._waiting:
                yield self._waiting.popleft()
            if self.is_over:
                return
            self._news.clear()
            await self._news.wait()


class Hub:
    """
    Give the frames of one source to those who read them.

    All but `publish` and `describe` is called in the event loop's thread.

    Parameters
    ----------
    profiles : sequence of Profile
        The forms that may be read.
    memory_s : float
        How far back a reader may begin, s.
    most_readers : int
        How many may read at once.
    history : History, optional
        What is older.

    Attributes
    ----------
    about : About
        What the frames are of.
    dropped : int
        Readers who were too slow.
    trouble : str
        Why the last of those who asked for the past was told none; empty: there was no trouble.

    """

    def __init__(
        self,
        profiles: Sequence[Profile],
        memory_s: float,
        most_readers: int,
        history: History | None = None,
    ) -> None:
        self.profiles = {profile.name: profile for profile in profiles}
        self.about = About()
        self.dropped = 0
        self.trouble = ''
        self._memory_ns, self._most_readers = round(memory_s * 1e9), most_readers
        self._history = history
        self._is_described = asyncio.Event()
        self._asking = asyncio.Semaphore(2)  # who reads old frames waits, the database does not
        self._memory: deque[Entry] = deque(maxlen=MOST_REMEMBERED)
        self._readers: dict[str, list[Reader]] = {name: [] for name in self.profiles}
        self._packers = {name: SharedPacker() for name in self.profiles}
        self._loop: asyncio.AbstractEventLoop | None = None

    def open(self, loop: asyncio.AbstractEventLoop) -> None:
        """Say in which loop readers wait."""
        self._loop = loop

    def publish(self, frame: Frame) -> None:
        """Give a frame to all readers; from any thread."""
        self._call(lambda: self._publish(frame))

    def describe(self, about: About) -> None:
        """Say what the frames are of; if it is another run, streams end; from any thread."""
        self._call(lambda: self._describe(about))

    @property
    def count(self) -> int:
        """How many read."""
        return sum(map(len, self._readers.values()))

    @property
    def is_full(self) -> bool:
        """Whether nobody else may read."""
        return self.count >= self._most_readers

    async def described(self) -> None:
        """Wait until it is known which run it is, but not for long."""
        with suppress(TimeoutError):
            await asyncio.wait_for(self._is_described.wait(), UNKNOWN_S)

    def join(self, profile: Profile, drop: Callable[[], None]) -> Reader:
        """
        Return a reader; he counts until he has left `read`.

        Parameters
        ----------
        profile : Profile
            The form.
        drop : callable
            Ends his connection at once.

        """

        def dropping() -> None:
            self.dropped += 1
            drop()

        reader = Reader(profile, self.about, dropping)
        self._readers[profile.name].append(reader)
        return reader

    def leave(self, reader: Reader) -> None:
        """Forget a reader."""
        readers = self._readers[reader.profile.name]
        if reader in readers:
            readers.remove(reader)

    async def read(self, reader: Reader, since_ns: int | None = None) -> AsyncIterator[Block]:
        """
        Yield the blocks for a reader: after a stamp, ns, as far as they are known, then live.

        Parameters
        ----------
        reader : Reader
            Who `join`-ed.
        since_ns : int, optional
            The stamp; None: only what comes.

        """
        if since_ns is not None:
            async for block in self._past(reader, since_ns):
                yield block
        reader.is_live = True
        async for block in reader.blocks():
            yield block

    def end(self) -> None:
        """Let all streams end."""
        for readers in self._readers.values():
            for reader in readers:
                reader.end()

    async def _past(self, reader: Reader, last_ns: int) -> AsyncIterator[Block]:
        """Yield what came after a stamp, ns, until the reader has all but what comes next."""
        past = self._history(reader.about, last_ns) if self._history else None
        exhausted_ns = -1
        while not reader.is_over:
            oldest_ns = self._memory[0].frame.stamp_ns if self._memory else _LATEST_NS
            found: list[tuple[int, bytes]] = []
            if past and last_ns < oldest_ns and oldest_ns != exhausted_ns:
                found = await self._stored(past, reader.profile, last_ns, oldest_ns)
                exhausted_ns = exhausted_ns if found else oldest_ns
            if not found:
                start = bisect_right(self._memory, last_ns, key=lambda each: each.frame.stamp_ns)
                entries = list(islice(self._memory, start, start + _AT_ONCE))
                if not entries:
                    return
                found = [(each.frame.stamp_ns, each.text(reader.profile)) for each in entries]
            for number, (_, text) in enumerate(found):
                if number % _AT_ONCE == 0:
                    await asyncio.sleep(0)
                reader.began_s = asyncio.get_running_loop().time()
                yield Block(text)
                reader.began_s = None
            last_ns = found[-1][0]

    async def _stored(
        self, past: Past, profile: Profile, after_ns: int, before_ns: int
    ) -> list[tuple[int, bytes]]:
        """Return stamps and texts of the next frames of the past; none if there is trouble."""

        def fetched() -> list[tuple[int, bytes]]:
            frames = past.next(after_ns, before_ns)
            return [(frame.stamp_ns, profile.frame(frame).encode()) for frame in frames]

        async with self._asking:
            try:
                found = await asyncio.to_thread(fetched)
                self.trouble = ''
            except StoreError as error:
                found, self.trouble = [], str(error)
        return found

    def _publish(self, frame: Frame) -> None:
        memory = self._memory
        if memory and frame.stamp_ns <= memory[-1].frame.stamp_ns:
            memory.clear()  # time begins anew
        while memory and memory[0].frame.stamp_ns < frame.stamp_ns - self._memory_ns:
            memory.popleft()
        entry, now_s = Entry(frame), asyncio.get_running_loop().time()
        memory.append(entry)
        for name, readers in self._readers.items():
            for reader in list(readers):
                reader.drop_if_stuck(now_s)
            live = [reader for reader in readers if reader.is_live]
            if not live:
                self._packers[name].pause()
                continue
            block = self._packers[name].pack(entry.text(self.profiles[name]))
            for reader in live:
                reader.offer(block)

    def _describe(self, about: About) -> None:
        if about != self.about:
            self.about = about
            if about.run:
                self._is_described.set()
            self._memory.clear()
            self.end()

    def _call(self, step: Callable[[], None]) -> None:
        loop = self._loop
        if loop is not None and not loop.is_closed():
            loop.call_soon_threadsafe(step)
