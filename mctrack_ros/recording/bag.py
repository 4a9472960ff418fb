"""Bags: rosbag2 directories, read and written without ROS."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeVar

import numpy as np
from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import Reader, StoragePlugin, Writer, WriterError
from rosbags.typesys import Stores, get_typestore

from mctrack_ros.codec import CodecError, MessageClasses, cloud_from_rows, rows_from_cloud
from mctrack_ros.interfaces import Rows

AnyRows = TypeVar('AnyRows', bound=Rows)

_TYPES = get_typestore(Stores.ROS2_JAZZY)
_FOREVER = QosTime(2147483647, 4294967295)

ROSBAGS_CLASSES = MessageClasses(
    cloud=_TYPES.types['sensor_msgs/msg/PointCloud2'],
    field=_TYPES.types['sensor_msgs/msg/PointField'],
    header=_TYPES.types['std_msgs/msg/Header'],
    time=_TYPES.types['builtin_interfaces/msg/Time'],
    image=_TYPES.types['sensor_msgs/msg/Image'],
    compressed_image=_TYPES.types['sensor_msgs/msg/CompressedImage'],
    octets=lambda data: np.array(data, np.uint8),
)
"""The message classes of rosbags, for the codec."""


class BagError(RuntimeError):
    """A bag that cannot be read or written; names the bag and the reason."""


class BagWriter:
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
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._writer = Writer(self.path, version=9, storage_plugin=StoragePlugin.MCAP)
            self._writer.open()
        except (OSError, WriterError) as error:
            raise BagError(f'{self.path} cannot be written: {error}') from error

    def write(self, topic: str, message: Any, time_ns: int) -> None:
        """Append a message of `ROSBAGS_CLASSES` or another rosbags type."""
        kind = message.__msgtype__
        self.write_serialized(topic, kind, bytes(_TYPES.serialize_cdr(message, kind)), time_ns)

    def write_rows(
        self, topic: str, rows: Rows, frame_id: str, time_ns: int | None = None
    ) -> None:
        """Append rows as a cloud, logged at their own stamp unless a time is given."""
        cloud = cloud_from_rows(rows, ROSBAGS_CLASSES, frame_id)
        self.write(topic, cloud, rows.stamp_ns if time_ns is None else time_ns)

    def write_text(self, topic: str, text: str, time_ns: int) -> None:
        """Append a ``std_msgs/String`` on a latched topic."""
        self.write(topic, _TYPES.types['std_msgs/msg/String'](data=text), time_ns)

    def write_serialized(self, topic: str, kind: str, data: bytes, time_ns: int) -> None:
        """Append a message that is serialised already; ``kind`` as in ``std_msgs/msg/String``."""
        connection = self._connections.get(topic)
        if connection is None:
            if kind not in _TYPES.types:
                raise BagError(f'{self.path}: message type {kind!r} of {topic} is not known')
            latched = kind == 'std_msgs/msg/String'
            connection = self._writer.add_connection(
                topic, kind, typestore=_TYPES, offered_qos_profiles=[_qos(latched)]
            )
            self._connections[topic] = connection
        self._writer.write(connection, int(time_ns), data)

    def close(self) -> None:
        """Finish the bag; what is not closed cannot be read."""
        self._writer.close()

    def __enter__(self) -> Self:
        """Return the writer itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Finish the bag, after an error too, so that nothing written is lost."""
        self.close()


class BagReader:
    """
    Read a rosbag2 directory (MCAP or SQLite), in the order of logging.

    Parameters
    ----------
    path : str or Path
        The directory that holds ``metadata.yaml``.

    Raises
    ------
    BagError
        If it is missing, empty, cut off or damaged.

    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        if not self.path.exists():
            raise BagError(f'{self.path} does not exist')
        if not (self.path / 'metadata.yaml').exists():
            raise BagError(
                f'{self.path} is not a finished bag: it has no metadata.yaml '
                '(was its recording cut off?)'
            )
        self._reader = Reader(self.path)
        self._guarded(self._reader.open)
        if self._reader.message_count == 0:
            self._reader.close()
            raise BagError(f'{self.path} holds no messages')

    @property
    def topics(self) -> dict[str, str]:
        """Message type by topic."""
        return {connection.topic: connection.msgtype for connection in self._reader.connections}

    @property
    def duration_s(self) -> float:
        """Time from the first to the last message, s."""
        return float(self._reader.duration * 1e-9)

    def count(self, topic: str) -> int:
        """Return how many messages a topic holds."""
        return sum(c.msgcount for c in self._reader.connections if c.topic == topic)

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
            if kind not in _TYPES.types:
                if topics is None:
                    continue
                raise BagError(f'{self.path}: message type {kind!r} of {topic} is not known')
            # a view: what is cut out of it is not copied
            message = self._guarded(_TYPES.deserialize_cdr, memoryview(data), kind)
            yield topic, message, time_ns

    def rows(
        self,
        topic: str,
        kind: type[AnyRows],
        start_ns: int | None = None,
        stop_ns: int | None = None,
    ) -> Iterator[tuple[AnyRows, int]]:
        """
        Yield a topic's clouds as rows, each with its log time (ns); the part as in `messages`.

        Raises
        ------
        BagError
            As `messages`, or if a message does not hold such rows.

        """
        for _, message, time_ns in self.messages([topic], start_ns, stop_ns):
            try:
                rows = rows_from_cloud(message, kind)
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
        missing = set(topics or ()) - self.topics.keys()
        if missing:
            raise BagError(f'{self.path} has no topic {sorted(missing)[0]}')
        wanted = [c for c in self._reader.connections if topics is None or c.topic in topics]
        stream = self._reader.messages(wanted, start_ns, stop_ns)
        while True:
            item = self._guarded(next, stream, None)
            if item is None:
                return
            connection, time_ns, data = item
            yield connection.topic, connection.msgtype, data, time_ns

    def close(self) -> None:
        """Close the files."""
        self._reader.close()

    def __enter__(self) -> Self:
        """Return the reader itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the files."""
        self.close()

    def _guarded(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """Call into rosbags; whatever it raises on a damaged bag becomes a `BagError`."""
        try:
            return call(*arguments)
        except Exception as error:
            reason = str(error) or type(error).__name__
            raise BagError(f'{self.path} cannot be read: {reason}') from error


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


def _qos(latched: bool) -> Qos:
    """Return the offered quality of service: reliable, latched for what is said once."""
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if latched else 10,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=_FOREVER,
        lifespan=_FOREVER,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_FOREVER,
        avoid_ros_namespace_conventions=False,
    )
