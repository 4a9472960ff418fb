"""Bags: rosbag2 directories, read and written without ROS."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Collection, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from rosbags.interfaces import Connection, ConnectionExtRosbag2, Qos
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.typesys.store import Typestore

from mctrack_ros.codec import CodecError, MessageClasses, message_from_ros, ros_from_message
from mctrack_ros.interfaces import Message
from mctrack_ros.recording.bags.definitions import (
    TYPES,
    TypeDefinition,
    known_definition,
    stated_definition,
    types_for,
)
from mctrack_ros.recording.bags.files import one_line, open_bag
from mctrack_ros.recording.bags.qos import OF_ROWS, OF_TYPES, USUAL
from mctrack_ros.recording.closing import Closing
from mctrack_ros.recording.errors import BagError

_NO_HASH = f'RIHS00_{0:064}'
"""Of a type whose hash nobody knows; rosbags does not write an empty one."""

AnyRows = TypeVar('AnyRows', bound=Message)

ROSBAGS_CLASSES = MessageClasses(
    cloud=TYPES.types['sensor_msgs/msg/PointCloud2'],
    field=TYPES.types['sensor_msgs/msg/PointField'],
    header=TYPES.types['std_msgs/msg/Header'],
    time=TYPES.types['builtin_interfaces/msg/Time'],
    image=TYPES.types['sensor_msgs/msg/Image'],
    compressed_image=TYPES.types['sensor_msgs/msg/CompressedImage'],
    octets=lambda data: np.array(data, np.uint8),
)
"""The message classes of rosbags, for the codec."""


class BagWriter(Closing):
    """
    Write a rosbag2 directory (MCAP), one message at a time.

    Parameters
    ----------
    path : str or Path
        The directory; its parents are made.
    overwrite : bool
        Whether a bag already there is replaced. Anything else there never is.

    Raises
    ------
    BagError
        If something is there already, or the file system refuses.

    """

    def __init__(self, path: str | Path, *, overwrite: bool = False) -> None:
        self.path = Path(path)
        check_place(self.path, overwrite)
        if self.path.exists():
            shutil.rmtree(self.path)
        self._connections: dict[str, Connection] = {}
        self._definitions: dict[str, TypeDefinition] = {}
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._writer = Writer(self.path, version=9, storage_plugin=StoragePlugin.MCAP)
            self._writer.open()
        except (OSError, WriterError) as error:
            raise BagError(f'{self.path} cannot be written: {error}') from error

    def write(
        self, topic: str, message: Any, time_ns: int, offered: Sequence[Qos] | None = None
    ) -> None:
        """
        Append a message of `ROSBAGS_CLASSES` or another type that rosbags knows.

        Unless another quality of service is given, the topic is said to offer what the graph's
        own nodes offer for messages of that type.

        """
        kind = message.__msgtype__
        data = bytes(TYPES.serialize_cdr(message, kind))
        self.write_serialized(
            topic, kind, data, time_ns, offered=offered or [OF_TYPES.get(kind, USUAL)]
        )

    def write_rows(
        self, topic: str, rows: Message, frame_id: str, time_ns: int | None = None
    ) -> None:
        """Append rows or a mask, logged at their own stamp unless a time is given."""
        message = ros_from_message(rows, ROSBAGS_CLASSES, frame_id)
        offered = [OF_ROWS.get(type(rows), USUAL)]
        self.write(topic, message, rows.stamp_ns if time_ns is None else time_ns, offered)

    def write_text(self, topic: str, text: str, time_ns: int) -> None:
        """Append a ``std_msgs/String`` on a latched topic."""
        self.write(topic, TYPES.types['std_msgs/msg/String'](data=text), time_ns)

    def write_serialized(
        self,
        topic: str,
        kind: str,
        data: bytes,
        time_ns: int,
        definition: TypeDefinition | None = None,
        offered: Sequence[Qos] = (),
    ) -> None:
        """
        Append a message that is serialised already.

        Parameters
        ----------
        topic : str
            Its topic.
        kind : str
            Its type, as in ``std_msgs/msg/String``.
        data : bytes
            The message.
        time_ns : int
            Log time, ns.
        definition : TypeDefinition, optional
            Of its type; unless given, what rosbags knows.
        offered : sequence of Qos
            What the topic's publishers offer; as the definition, it counts with the topic's first
            message.

        Raises
        ------
        BagError
            If the type is not known, or was defined in another way before.

        """
        connection = self._connections.get(topic)
        if connection is None:
            definition = definition or known_definition(kind)
            if definition is None:
                raise BagError(f'{self.path}: message type {kind!r} of {topic} is not known')
            if self._definitions.setdefault(kind, definition) != definition:
                raise BagError(f'{self.path}: {topic} has another definition of {kind!r}')
            connection = self._writer.add_connection(
                topic,
                kind,
                msgdef=definition.text,
                rihs01=definition.type_hash or _NO_HASH,
                offered_qos_profiles=offered,
            )
            self._connections[topic] = connection
        self._writer.write(connection, int(time_ns), data)

    def write_copy(
        self, reader: BagReader, topic: str, kind: str, data: bytes, time_ns: int
    ) -> None:
        """Append what `BagReader.serialized` yields, with its type and quality of service."""
        new = topic not in self._connections
        definition = reader.definition(topic) if new else None
        offered = reader.offered(topic) if new else ()
        self.write_serialized(topic, kind, data, time_ns, definition, offered)

    def close(self) -> None:
        """Finish the bag; what is not closed cannot be read."""
        self._writer.close()


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
        begin_ns = min(storage.start_time for storage in filled)
        return float((max(storage.end_time for storage in filled) - begin_ns) * 1e-9)

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
    ) -> Iterator[tuple[AnyRows, int]]:
        """
        Yield a topic's clouds as rows, or its masks, each with its log time (ns).

        Start and stop are as in `messages`.

        Raises
        ------
        BagError
            As `messages`, or if a message does not hold such rows.

        """
        for _, message, time_ns in self.messages([topic], start_ns, stop_ns):
            try:
                rows = message_from_ros(message, kind)
            except (CodecError, AttributeError) as error:
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


def check_place(path: Path, overwrite: bool) -> None:
    """
    Refuse a place where something is that a bag may not replace.

    Raises
    ------
    BagError
        If there is a bag that is not to be replaced, or something else.

    """
    if not path.exists():
        return
    if not (path / 'metadata.yaml').exists():
        raise BagError(f'{path} exists already and is no bag: choose another name or remove it')
    if not overwrite:
        raise BagError(
            f'{path} exists already: choose another name, or replace it by --overwrite '
            "(a node's parameter: overwrite)"
        )
