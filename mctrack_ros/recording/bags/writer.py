"""Bags: rosbag2 directories, written without ROS."""

from __future__ import annotations

import shutil
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml
from rosbags.interfaces import Qos, QosDurability
from rosbags.rosbag2.metadata import dump_qos_v9

from mctrack_ros.codec import MessageClasses, ros_from_message
from mctrack_ros.interfaces import Message
from mctrack_ros.recording.bags.definitions import (
    NO_HASH,
    TYPES,
    TypeDefinition,
    known_definition,
)
from mctrack_ros.recording.bags.mcap_file import McapFile
from mctrack_ros.recording.bags.qos import OF_ROWS, OF_TYPES, USUAL
from mctrack_ros.recording.bags.sqlite_file import SqliteFile
from mctrack_ros.recording.closing import Closing
from mctrack_ros.recording.errors import BagError
from mctrack_ros.recording.track_log.log import CHECKSUMS, SUMMARY, MessageLog, packed

if TYPE_CHECKING:
    from mctrack_ros.recording.bags.bag import BagReader

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

_SUFFIXES = {'mcap': '.mcap', 'sqlite3': '.db3'}
_LATCHED_KEPT = 10
"""Number of messages of a latched topic that are repeated, if the publisher states no depth."""


@dataclass(frozen=True, slots=True)
class Storage:
    """
    How a bag is stored.

    Attributes
    ----------
    kind : str
        ``mcap`` or ``sqlite3``; the latter holds no attachments.
    is_packed : bool
        Whether chunks of MCAP are compressed, by zstd.
    most_bytes : int
        Size from which another file is begun; 0: none is.
    most_ns : int
        Length from which another file is begun, ns; 0: none is.

    """

    kind: str = 'mcap'
    is_packed: bool = False
    most_bytes: int = 0
    most_ns: int = 0


PLAIN = Storage()
"""One MCAP file without compression."""


@dataclass(slots=True)
class _Topic:
    """A topic of the bag: how it is described, and what is kept of it if it is latched."""

    kind: str
    definition: TypeDefinition
    offered: list[Qos]
    kept: deque[bytes] | None
    count: int = 0

    def follow(self, offered: Sequence[Qos]) -> None:
        """Keep as many messages as all publishers of the topic do together, now that they are."""
        if self.kept is None:
            return
        depth = sum(each.depth or _LATCHED_KEPT for each in offered)
        if depth > (self.kept.maxlen or 0):
            self.kept = deque(self.kept, maxlen=depth)


class BagWriter(Closing):
    """
    Write a rosbag2 directory, one message at a time.

    An MCAP bag carries the hash of the tracks in it and checksums of its messages as attachments;
    see `mctrack_ros.recording.track_log`. Where another file is begun, it begins with what latched
    topics hold, and with the attachments given so far.

    Parameters
    ----------
    path : str or Path
        The directory; its parents are made.
    overwrite : bool
        Whether a bag already there is replaced. Anything else there never is.
    storage : Storage
        How it is stored.
    made_by : mapping of str to str, optional
        Versions and processor that the messages come of; unless given, those of here.

    Raises
    ------
    BagError
        If something is there already, or the file system refuses.

    """

    def __init__(
        self,
        path: str | Path,
        *,
        overwrite: bool = False,
        storage: Storage = PLAIN,
        made_by: Mapping[str, str] | None = None,
    ) -> None:
        self.path, self._storage = Path(path), storage
        check_place(self.path, overwrite)
        self._topics: dict[str, _Topic] = {}
        self._definitions: dict[str, TypeDefinition] = {}
        self._files: list[McapFile | SqliteFile] = []
        self._attached: dict[str, tuple[str, bytes]] = {}
        self._log, self._blocks, self._last_ns = MessageLog(made_by), 0, 0
        try:
            if self.path.exists():
                shutil.rmtree(self.path)
            self.path.mkdir(parents=True)
            self._open()
        except OSError as error:
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
            What the topic's publishers offer. What is stated of the topic is that of its first
            message; of a latched one, as much is repeated as all publishers keep.

        Raises
        ------
        BagError
            If the type is not known, or was defined in another way before.
        OSError
            If the disk is full, for example.

        """
        time_ns = int(time_ns)
        known = self._topics.get(topic)
        if known is None:
            known = self._add(topic, kind, definition, offered)
        known.follow(offered)
        if self._is_full(time_ns):
            self._split(time_ns)
        self._put(topic, known, time_ns, data)
        if known.kept is not None:
            known.kept.append(data)
        if self._log.is_full:
            self._put_checksums()

    def write_copy(
        self, reader: BagReader, topic: str, kind: str, data: bytes, time_ns: int
    ) -> None:
        """Append what `BagReader.serialized` yields, with its type and quality of service."""
        new = topic not in self._topics
        definition = reader.definition(topic) if new else None
        offered = reader.offered(topic) if new else ()
        self.write_serialized(topic, kind, data, time_ns, definition, offered)

    def attach(self, files: Mapping[str, bytes], media_type: str) -> None:
        """Append attachments, by name; each file of the bag carries them."""
        for name, data in files.items():
            self._attached[name] = media_type, data
            self._files[-1].attach(name, media_type, data, self._last_ns)

    def flush(self) -> None:
        """Hand all that was written to the system: what is killed then, has it."""
        self._files[-1].flush()

    def close(self) -> None:
        """Finish the bag; what is not closed lacks its index and the hash of its tracks."""
        self._put_log()
        self._files[-1].close(self._metadata())
        place = self.path / 'metadata.yaml'
        new = place.with_suffix('.new')
        new.write_text(f'rosbag2_bagfile_information:\n{_indented(self._metadata())}', 'utf-8')
        new.replace(place)

    def _open(self) -> None:
        """Begin a file."""
        number = f'_{len(self._files)}' if self._splits else ''
        path = self.path / f'{self.path.name}{number}{_SUFFIXES[self._storage.kind]}'
        if self._storage.kind == 'mcap':
            self._files.append(McapFile(path, is_packed=self._storage.is_packed))
        else:
            self._files.append(SqliteFile(path))
        for name, (media_type, data) in self._attached.items():
            self._files[-1].attach(name, media_type, data, self._last_ns)
        self._put_log()

    @property
    def _splits(self) -> bool:
        return bool(self._storage.most_bytes or self._storage.most_ns)

    def _is_full(self, time_ns: int) -> bool:
        file, storage = self._files[-1], self._storage
        if not self._splits or not file.counts:
            return False
        return bool(
            (storage.most_bytes and file.size >= storage.most_bytes)
            or (storage.most_ns and time_ns - file.begin_ns >= storage.most_ns)
        )

    def _split(self, time_ns: int) -> None:
        """Begin another file with what latched topics hold."""
        self._put_log()
        self._files[-1].close(self._metadata())
        self._open()
        for topic, known in self._topics.items():
            for data in known.kept or ():
                self._put(topic, known, time_ns, data)

    def _add(
        self, topic: str, kind: str, definition: TypeDefinition | None, offered: Sequence[Qos]
    ) -> _Topic:
        definition = definition or known_definition(kind)
        if definition is None:
            raise BagError(f'{self.path}: message type {kind!r} of {topic} is not known')
        if self._definitions.setdefault(kind, definition) != definition:
            raise BagError(f'{self.path}: {topic} has another definition of {kind!r}')
        is_latched = any(each.durability is QosDurability.TRANSIENT_LOCAL for each in offered)
        kept = deque[bytes](maxlen=0) if is_latched and self._splits else None
        known = _Topic(kind, definition, list(offered), kept)
        self._topics[topic] = known
        return known

    def _put(self, topic: str, known: _Topic, time_ns: int, data: bytes) -> None:
        """Write a message into the file that is open."""
        file = self._files[-1]
        if topic not in file.counts:
            file.add(topic, known.kind, known.definition, known.offered)
        file.write(topic, time_ns, data)
        self._log.add(topic, known.kind, data, time_ns)
        known.count += 1
        self._last_ns = time_ns

    def _put_checksums(self) -> None:
        """Attach the checksums of what was written since the last ones."""
        taken = self._log.take_checksums()
        if taken and self._storage.kind == 'mcap':
            name = f'{CHECKSUMS}/{self._blocks:06}'
            self._files[-1].attach(name, 'application/x-npz', packed(taken), self._last_ns)
            self._blocks += 1

    def _put_log(self) -> None:
        """Attach what is known of the log so far."""
        self._put_checksums()
        summary = self._log.summary()
        self._files[-1].attach(SUMMARY, 'application/json', summary, self._last_ns)

    def _metadata(self) -> str:
        """Return the metadata of the bag so far, as rosbag2 writes them, version 9."""
        files = [file for file in self._files if file.counts] or self._files[-1:]
        begin_ns = min(file.begin_ns for file in files)
        counted = [
            {
                'topic_metadata': {
                    'name': topic,
                    'type': known.kind,
                    'serialization_format': 'cdr',
                    'offered_qos_profiles': dump_qos_v9(known.offered),
                    'type_description_hash': known.definition.type_hash or NO_HASH,
                },
                'message_count': known.count,
            }
            for topic, known in self._topics.items()
        ]
        values = {
            'version': 9,
            'storage_identifier': self._storage.kind,
            'duration': _nanoseconds(max(file.end_ns for file in files) - begin_ns),
            'starting_time': {'nanoseconds_since_epoch': begin_ns},
            'message_count': sum(known.count for known in self._topics.values()),
            'topics_with_message_count': counted,
            'compression_format': '',
            'compression_mode': '',
            'relative_file_paths': [file.path.name for file in self._files],
            'files': [
                {
                    'path': file.path.name,
                    'starting_time': {'nanoseconds_since_epoch': file.begin_ns},
                    'duration': _nanoseconds(file.end_ns - file.begin_ns),
                    'message_count': sum(file.counts.values()),
                }
                for file in self._files
            ],
            'custom_data': None,
            'ros_distro': 'rosbags',
        }
        return yaml.safe_dump(values, sort_keys=False)


def _nanoseconds(duration_ns: int) -> dict[str, int]:
    return {'nanoseconds': max(duration_ns, 0)}


def _indented(text: str) -> str:
    return ''.join(f'  {line}\n' for line in text.splitlines())


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
