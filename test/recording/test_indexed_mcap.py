import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.rosbag2.errors import ReaderError
from rosbags.typesys import Stores, get_typestore

from mctrack_ros.recording.indexed_mcap import IndexedReader

TYPES = get_typestore(Stores.ROS2_JAZZY)
TOPICS = ('/cam1', '/cam2', '/site')
LARGE = 300_000  # bytes of a message: some four fill a chunk


@pytest.fixture(params=[None, CompressionMode.STORAGE, CompressionMode.MESSAGE])
def bag(tmp_path, request):
    """Return a bag of several chunks, of messages that come out of order and at equal times."""
    rng = np.random.default_rng(1)
    path = tmp_path / 'bag'
    writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
    if request.param is not None:
        writer.set_compression(request.param, CompressionFormat.ZSTD)
    with writer:
        kind = 'std_msgs/msg/String'
        connections = [writer.add_connection(topic, kind, typestore=TYPES) for topic in TOPICS]
        for index in range(40):
            size = LARGE if index % 3 else 10
            time_ns = 5 + index // 2 + int(rng.integers(-3, 4))
            writer.write(connections[int(rng.integers(3))], time_ns, rng.bytes(size))
    return path


@pytest.mark.parametrize('topics', [TOPICS, TOPICS[:1], TOPICS[1:]])
@pytest.mark.parametrize('span', [(None, None), (8, 17), (None, 12), (12, None)])
def test_messages_are_those_of_rosbags_in_its_order(bag, topics, span):
    read = []
    for kind in (Reader, IndexedReader):
        with kind(bag) as reader:
            wanted = [each for each in reader.connections if each.topic in topics]
            stream = reader.messages(wanted, *span)
            read.append([(each.topic, time_ns, bytes(data)) for each, time_ns, data in stream])
    assert len(read[0]) >= 3
    assert read[1] == read[0]


def test_messages_that_are_not_wanted_are_not_read(bag, monkeypatch):
    with IndexedReader(bag) as reader:
        (storage,) = reader.storage.storages
        if any(chunk.compression for chunk in storage.chunks):
            pytest.skip('compressed chunks are read whole')
        wanted = [each for each in reader.connections if each.topic == '/cam1']
        channels = []
        message = storage._message
        monkeypatch.setattr(
            storage, '_message', lambda place, one: channels.append(one) or message(place, one)
        )
        assert len(list(reader.messages(wanted))) == len(channels) == wanted[0].msgcount


def test_an_index_that_points_elsewhere_is_refused(bag):
    with IndexedReader(bag) as reader:
        (storage,) = reader.storage.storages
        if any(chunk.compression for chunk in storage.chunks):
            pytest.skip('compressed chunks are read whole')
        chunk = storage.chunks[0]
        channel, place = next(iter(chunk.message_index_offsets.items()))
        chunk.message_index_offsets[channel] = place + 1
        with pytest.raises(ReaderError, match='damaged'):
            list(reader.messages())
        with pytest.raises(ReaderError, match='no message of channel'):
            storage._message(chunk.chunk_start_offset, channel)
