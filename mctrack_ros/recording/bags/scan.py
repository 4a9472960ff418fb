"""All messages of a file that can be read, found one by one; and what of it is lost."""

from __future__ import annotations

from abc import ABC, abstractmethod
from array import array
from collections.abc import Collection, Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Connection


class Loss(NamedTuple):
    """
    What is damaged in the middle of a file.

    Attributes
    ----------
    begin_ns, end_ns : int
        Log times between which it lies, ns.
    messages : int
        How many are lost; 0: nobody knows.

    """

    begin_ns: int
    end_ns: int
    messages: int


class Scan(ABC):
    """
    A file that was read to its end, or to where it breaks off.

    Attributes
    ----------
    connections : list of Connection
        Its topics.
    is_whole : bool
        Whether it does not break off.
    losses : list of Loss
        What is damaged before that.

    """

    def __init__(self) -> None:
        self.connections: list[Connection] = []
        self.is_whole = False
        self.losses: list[Loss] = []
        self._index: NDArray[np.int64] = np.empty((0, 2), np.int64)

    @property
    def message_count(self) -> int:
        """How many messages were found."""
        return len(self._index)

    @property
    def start_time(self) -> int:
        """Log time of the first message, ns."""
        return int(self._index[0, 0])

    @property
    def end_time(self) -> int:
        """Just after the log time of the last message, ns."""
        return int(self._index[-1, 0]) + 1

    def messages(
        self,
        connections: Collection[Connection] = (),
        start: int | None = None,
        stop: int | None = None,
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield connection, log time (ns) and data, from a start until before a stop."""
        wanted = {each.id: each for each in connections or self.connections}
        times = self._index[:, 0]
        first = 0 if start is None else np.searchsorted(times, start)
        last = len(times) if stop is None else np.searchsorted(times, stop)
        for time_ns, topic, *place in self._index[first:last].tolist():
            if topic in wanted:
                yield wanted[topic], time_ns, self._data(*place)

    def _keep(self, found: array[int], columns: int, topics: Iterable[Connection]) -> None:
        """Keep what was found: log time, topic, and where the data are, one after another."""
        index = np.frombuffer(found, np.int64).reshape(-1, columns)
        self._index = index[np.argsort(index[:, 0], kind='stable')]
        self.connections = [
            topic._replace(msgcount=int(np.count_nonzero(index[:, 1] == topic.id)))
            for topic in topics
        ]

    @abstractmethod
    def _data(self, *place: int) -> bytes:
        """Return a message's data."""
