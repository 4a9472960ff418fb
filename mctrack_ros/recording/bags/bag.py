"""Bags: rosbag2 directories, read without ROS."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from rosbags.interfaces import Connection, ConnectionExtRosbag2, Qos
from rosbags.typesys.store import Typestore

from mctrack_ros.codec import CodecError, message_from_ros
from mctrack_ros.interfaces import Message
from mctrack_ros.recording.bags.definitions import TypeDefinition, stated_definition, types_for
from mctrack_ros.recording.bags.files import one_line, open_bag
from mctrack_ros.recording.closing import Closing
from mctrack_ros.recording.errors import BagError

AnyRows = TypeVar('AnyRows', bound=Message)


class BagReader(Closing):
    """
    Read a bag (MCAP or SQLite), in the order of logging.

    Parameters
    ----------
    path : str or Path
        A rosbag2 folder, finished or not, or one of its files.
    namespace : str
        Topics in it are named, and found, as if they lay in none; they hide others of that name.
    scanned : bool
        Whether it is read from end to end at once, past what is damaged.

    Warns
    -----
    CutBagWarning
        If it breaks off or is damaged; it is read as far as it goes.

    Raises
    ------
    BagError
        If it is missing, empty or damaged.

    """

    def __init__(self, path: str | Path, namespace: str = '', *, scanned: bool = False) -> None:
        self.path, self._namespace = Path(path), namespace
        self._storages = self._guarded(partial(open_bag, scanned=scanned), self.path)
        self._types: dict[str, Typestore | None] = {}
        if not any(storage.message_count for storage in self._storages):
            self.close()
            raise BagError(f'{self.path} holds no messages')

    @property
    def topics(self) -> dict[str, str]:
        """Message type by topic."""
        connections = self._connections()
        names = {c.topic: self._name(c.topic) for c in connections}
        inner = {name for topic, name in names.items() if topic != name}
        shown = [c for c in connections if c.topic not in inner]
        return {names[connection.topic]: connection.msgtype for connection in shown}

    @property
    def duration_s(self) -> float:
        """Time from the first to the last message, s."""
        filled = [storage for storage in self._storages if storage.message_count]
        return float((max(storage.end_time for storage in filled) - self.begin_ns) * 1e-9)

    @property
    def begin_ns(self) -> int:
        """Log time of the first message, ns."""
        return int(min(s.start_time for s in self._storages if s.message_count))

    @property
    def end_ns(self) -> int:
        """Log time of the last message, ns."""
        return int(max(s.end_time for s in self._storages if s.message_count)) - 1

    def count(self, topic: str) -> int:
        """Return how many messages a topic holds."""
        return sum(c.msgcount for c in self._connections(topic))

    def definition(self, topic: str) -> TypeDefinition | None:
        """Return how the bag defines the type of a topic; None: it does not."""
        stated = map(stated_definition, self._connections(topic))
        return next((definition for definition in stated if definition), None)

    def offered(self, topic: str) -> list[Qos]:
        """Return what the publishers of a topic offered; empty: it was not recorded."""
        extensions = [connection.ext for connection in self._connections(topic)]
        known = [each for each in extensions if isinstance(each, ConnectionExtRosbag2)]
        return next((e.offered_qos_profiles for e in known if e.offered_qos_profiles), [])

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int | None = None,
        stop_ns: int | None = None,
    ) -> Iterator[tuple[str, Any, int]]:
        """
        Yield topic, message and log time (ns); of some topics, or of all with a known type.

        With a start or a stop, only what was logged from the one until before the other.

        Raises
        ------
        BagError
            If the bag ends in the middle, a topic asked for is not there, or its message type
            is not known.

        """
        for topic, kind, data, time_ns in self.serialized(topics, start_ns, stop_ns):
            if topic not in self._types:
                self._types[topic] = self._guarded(types_for, self._connections(topic)[0])
            types = self._types[topic]
            if types is None:
                if topics is None:
                    continue
                raise BagError(f'{self.path}: message type {kind!r} of {topic} is not known')
            # a view: what is cut out of it is not copied
            message = self._guarded(types.deserialize_cdr, memoryview(data), kind)
            yield topic, message, time_ns

    def rows(
        self,
        topic: str,
        kind: type[AnyRows],
        start_ns: int | None = None,
        stop_ns: int | None = None,
        *,
        usable: bool = False,
    ) -> Iterator[tuple[AnyRows, int]]:
        """
        Yield a topic's clouds as rows, or its masks, each with its log time (ns).

        Start and stop are as in `messages`. Of those ``usable`` alone, messages that a node would
        have refused are passed over.

        Raises
        ------
        BagError
            As `messages`, or if a message does not hold such rows.

        """
        for _, message, time_ns in self.messages([topic], start_ns, stop_ns):
            try:
                rows = message_from_ros(message, kind)
            except (CodecError, AttributeError) as error:
                if usable:
                    continue
                raise BagError(
                    f'{self.path}: {topic} holds no {kind.__name__}: {error}'
                ) from error
            yield rows, time_ns

    def serialized(
        self,
        topics: Collection[str] | None = None,
        start_ns: int | None = None,
        stop_ns: int | None = None,
    ) -> Iterator[tuple[str, str, bytes, int]]:
        """Yield topic, type, serialised message and log time (ns), as `messages` does."""
        asked = list(self.topics if topics is None else topics)
        missing = [topic for topic in asked if not self._connections(topic)]
        if missing:
            raise BagError(f'{self.path} has no topic {self._namespace}{min(missing)}')
        names = {c.topic: topic for topic in asked for c in self._connections(topic)}
        for storage in self._storages:
            wanted = [c for c in storage.connections if c.topic in names]
            if not wanted:
                continue
            stream = storage.messages(wanted, start_ns, stop_ns)
            while (item := self._guarded(next, stream, None)) is not None:
                connection, time_ns, data = item
                yield names[connection.topic], connection.msgtype, data, time_ns

    def close(self) -> None:
        """Close the files."""
        for storage in self._storages:
            storage.close()

    def _connections(self, topic: str | None = None) -> list[Connection]:
        """Return the connections of a topic, or of all, over all files."""
        found = [c for storage in self._storages for c in storage.connections]
        if topic is None:
            return found
        inner = [c for c in found if c.topic == f'{self._namespace}{topic}']
        return inner or [c for c in found if c.topic == topic]

    def _name(self, topic: str) -> str:
        """Return what a topic is called in the namespace."""
        inside = self._namespace and topic.startswith(f'{self._namespace}/')
        return topic.removeprefix(self._namespace) if inside else topic

    def _guarded(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """Call into rosbags; whatever it raises on a damaged bag becomes a `BagError`."""
        try:
            return call(*arguments)
        except (BagError, Warning):
            raise
        except Exception as error:
            raise BagError(f'{self.path} cannot be read: {one_line(error)}') from error
