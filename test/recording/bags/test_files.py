"""Bags that were not finished, or are one file: read as far as they go, and said so."""

import random
import shutil
import sqlite3
import warnings
import zlib
from contextlib import closing
from io import BytesIO

import lz4.frame
import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from mctrack_ros.recording import BagError, BagReader, BagWriter
from mctrack_ros.recording.bags.mcap_scan import MAGIC

TYPES = get_typestore(Stores.ROS2_JAZZY)
TEXT = 'std_msgs/msg/String'
COUNT = 60
START_NS = 1_700_000_000 * 10**9
STEP_NS = 10**8


def text(index):
    """Return a text of about 40 kB that packs badly, so that a bag has several chunks."""
    return f'{index} ' + random.Random(index).randbytes(20_000).hex()


def data_of(index):
    return bytes(TYPES.serialize_cdr(TYPES.types[TEXT](data=text(index)), TEXT))


def write_bag(folder, plugin=StoragePlugin.MCAP, mode=CompressionMode.NONE):
    """Write a bag by rosbags alone, of texts 0.1 s apart; return its only storage file."""
    writer = Writer(folder, version=9, storage_plugin=plugin)
    if mode is not CompressionMode.NONE:
        from rosbags.rosbag2 import CompressionFormat

        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection('/words', TEXT, typestore=TYPES)
        for index in range(COUNT):
            writer.write(connection, START_NS + index * STEP_NS, data_of(index))
    (file,) = (each for each in folder.iterdir() if each.name != 'metadata.yaml')
    return file


def read(path):
    """Return the texts of a bag, with what was warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter('always')
        with BagReader(path) as reader:
            texts = [message.data for _, message, _ in reader.messages(['/words'])]
    return texts, [str(warning.message) for warning in caught]


TEXTS = [text(index) for index in range(COUNT)]
KINDS = {
    'plain': (StoragePlugin.MCAP, CompressionMode.NONE),
    'zstd chunks': (StoragePlugin.MCAP, CompressionMode.STORAGE),
    'sqlite': (StoragePlugin.SQLITE3, CompressionMode.NONE),
}


@pytest.fixture(scope='session', params=KINDS, ids=KINDS.keys())
def finished(request, tmp_path_factory):
    """Return the only file of a finished bag."""
    return write_bag(tmp_path_factory.mktemp('finished') / 'bag', *KINDS[request.param])


@pytest.fixture(scope='session')
def plain(tmp_path_factory):
    """Return the only file of a finished MCAP bag."""
    return write_bag(tmp_path_factory.mktemp('plain') / 'bag')


def test_a_single_file_is_read(finished):
    assert read(finished) == (TEXTS, [])


def test_a_folder_without_metadata_is_read(finished, tmp_path):
    shutil.copy(finished, tmp_path)
    assert read(tmp_path) == (TEXTS, [])


def test_files_of_a_folder_without_metadata_are_read_in_the_order_of_their_numbers(tmp_path):
    for number in (2, 10, 1):
        with BagWriter(tmp_path / str(number)) as writer:
            writer.write_text('/words', str(number), number)
        shutil.copy(tmp_path / f'{number}/{number}.mcap', tmp_path / f'bag_{number}.mcap')
    assert read(tmp_path) == (['1', '2', '10'], [])


@pytest.mark.parametrize('share', [0.3, 0.5, 0.7, 0.95, 0.999])
@pytest.mark.parametrize('metadata', [True, False])
def test_a_cut_bag_is_read_up_to_the_cut(finished, tmp_path, share, metadata):
    shutil.copytree(finished.parent, tmp_path / 'cut')
    if not metadata:
        (tmp_path / 'cut/metadata.yaml').unlink()
    whole = finished.read_bytes()
    (tmp_path / 'cut' / finished.name).write_bytes(whole[: int(share * len(whole))])
    texts, (warning,) = read(tmp_path / 'cut')
    assert texts == TEXTS[: len(texts)]
    assert len(texts) >= share * COUNT - 8
    last_s = (len(texts) - 1) * STEP_NS * 1e-9
    assert f'{last_s:.3f} s after its start' in warning
    assert f'2023-11-14 22:13:{20 + last_s:06.3f}+00:00' in warning


def test_a_plain_file_is_read_to_the_last_whole_message_wherever_it_is_cut(plain, tmp_path):
    whole, rng = plain.read_bytes(), random.Random(1)
    ends = [whole.index(data_of(index)) + len(data_of(index)) for index in range(COUNT)]
    cuts = [rng.randrange(ends[0], len(whole)) for _ in range(60)]
    for cut in [*ends, *(end - 1 for end in ends[1:]), *cuts, len(whole) - 1]:
        (tmp_path / 'cut.mcap').write_bytes(whole[:cut])
        texts, (warning,) = read(tmp_path / 'cut.mcap')
        assert texts == TEXTS[: sum(end <= cut for end in ends)], cut
        assert 'breaks off' in warning


def test_what_was_cut_before_the_first_message_is_an_error(plain, tmp_path):
    whole = plain.read_bytes()
    for cut in range(1, whole.index(data_of(0)), 13):
        (tmp_path / 'cut.mcap').write_bytes(whole[:cut])
        with pytest.raises(BagError, match='breaks off before its first message'):
            BagReader(tmp_path / 'cut.mcap')


@pytest.mark.parametrize(
    ('name', 'content', 'reason'),
    [
        ('empty.mcap', b'', 'is empty'),
        ('empty.db3', b'', 'is empty'),
        ('noise.mcap', np.random.default_rng(1).bytes(5000), 'is no bag'),
        ('film.mp4', b'\0\0\0\x20ftypisom' * 9, 'is no bag'),
        ('old.bag', b'#ROSBAG V2.0\n' + bytes(99), 'rosbags-convert'),
        ('bag.mcap.zstd', bytes.fromhex('28b52ffd') + bytes(99), 'zstd -d'),
        ('zeros.mcap', MAGIC + bytes(999), 'breaks off before its first message'),
        ('fake.db3', b'SQLite format 3\0' + bytes(5000), 'cannot be read|breaks off'),
    ],
)
def test_files_of_another_kind_are_named_in_one_line(tmp_path, name, content, reason):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BagError, match=reason) as caught:
        BagReader(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_folder_without_storage_files_is_named(tmp_path):
    (tmp_path / 'thesis.txt').write_text('mine')
    with pytest.raises(BagError, match='is no bag: it holds no'):
        BagReader(tmp_path)


def test_a_file_that_the_metadata_names_and_that_is_not_there_is_warned_of(tmp_path):
    write_bag(tmp_path / 'bag')
    metadata = tmp_path / 'bag/metadata.yaml'
    listed = metadata.read_text()
    metadata.write_text(listed.replace('relative_file_paths:', 'relative_file_paths:\n  - b.mcap'))
    texts, (warning,) = read(tmp_path / 'bag')
    assert texts == TEXTS
    assert 'b.mcap' in warning


def record(code, content):
    return bytes([code]) + len(content).to_bytes(8, 'little') + content


def string(value):
    return len(value).to_bytes(4, 'little') + value.encode()


def flat_mcap(times, profile='ros2', end=True):
    """Return an MCAP file without chunks and index, as rosbag2 writes for speed."""
    out = BytesIO()
    out.write(MAGIC + record(1, string(profile) + string('test')))
    definition = string(TEXT) + string('ros2msg') + string('string data\n')
    out.write(record(3, (1).to_bytes(2, 'little') + definition))
    channel = (1).to_bytes(2, 'little') * 2 + string('/words') + string('cdr') + bytes(4)
    out.write(record(4, channel))
    for index, time_ns in enumerate(times):
        head = (1).to_bytes(2, 'little') + bytes(4) + time_ns.to_bytes(8, 'little') * 2
        out.write(record(5, head + data_of(index)))
    if end:
        out.write(record(15, bytes(4)) + record(2, bytes(20)) + MAGIC)
    return out.getvalue()


@pytest.mark.parametrize('profile', ['ros2', ''])
def test_unindexed_files_are_read_in_the_order_of_their_times(tmp_path, profile):
    (tmp_path / 'flat.mcap').write_bytes(flat_mcap([5, 3, 9], profile))
    assert read(tmp_path / 'flat.mcap') == ([TEXTS[1], TEXTS[0], TEXTS[2]], [])


def test_an_unindexed_file_in_a_finished_folder_is_read_without_a_warning(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write_text('/words', 'hello', 0)
    metadata = tmp_path / 'bag/metadata.yaml'
    content = yaml.safe_load(metadata.read_text())
    (topic,) = content['rosbag2_bagfile_information']['topics_with_message_count']
    del topic['topic_metadata']['offered_qos_profiles']
    metadata.write_text(yaml.safe_dump(content))
    (tmp_path / 'bag/bag.mcap').write_bytes(flat_mcap([5, 3, 9]))
    assert read(tmp_path / 'bag') == ([TEXTS[1], TEXTS[0], TEXTS[2]], [])


def test_a_cut_unindexed_file_is_read_up_to_the_cut(tmp_path):
    (tmp_path / 'flat.mcap').write_bytes(flat_mcap([5, 3, 9], end=False)[:-1])
    texts, (warning,) = read(tmp_path / 'flat.mcap')
    assert texts == [TEXTS[1], TEXTS[0]]
    assert 'breaks off' in warning


def chunk(index, damage=0, method=''):
    """Return a chunk of one text, with a checksum that does not fit if it is damaged."""
    head = (1).to_bytes(2, 'little') + bytes(4) + index.to_bytes(8, 'little') * 2
    inner = bytearray(record(5, head + data_of(index)))
    checksum = zlib.crc32(inner).to_bytes(4, 'little')
    inner[1000:1004] = bytes(byte ^ damage for byte in inner[1000:1004])
    times, size = index.to_bytes(8, 'little') * 2, len(inner).to_bytes(8, 'little')
    return record(6, times + size + checksum + string(method) + size + inner)


def test_of_a_damaged_chunk_nothing_is_made_up(tmp_path):
    head = flat_mcap([], end=False)
    (tmp_path / 'bag.mcap').write_bytes(head + chunk(0) + chunk(1) + chunk(2, damage=1) + chunk(3))
    texts, warnings = read(tmp_path / 'bag.mcap')
    assert texts == [*TEXTS[:2], TEXTS[3]]
    assert 'is damaged: messages are lost, 0.000 to 0.000 s after its start' in warnings[0]
    assert 'breaks off' in warnings[1]


def lz4_chunk(indices):
    """Return a chunk of some texts that is packed by LZ4."""
    inner = b''.join(
        record(
            5,
            (1).to_bytes(2, 'little')
            + bytes(4)
            + index.to_bytes(8, 'little') * 2
            + data_of(index),
        )
        for index in indices
    )
    packed = lz4.frame.compress(inner, block_size=lz4.frame.BLOCKSIZE_MAX64KB)
    head = bytes(16) + len(inner).to_bytes(8, 'little') + zlib.crc32(inner).to_bytes(4, 'little')
    return record(6, head + string('lz4') + len(packed).to_bytes(8, 'little') + packed)


def test_a_chunk_packed_by_lz4_is_read_up_to_the_cut(tmp_path):
    head, packed = flat_mcap([], end=False), lz4_chunk(range(1, 21))
    (tmp_path / 'whole.mcap').write_bytes(head + packed + record(2, bytes(20)) + MAGIC)
    assert read(tmp_path / 'whole.mcap') == (TEXTS[1:21], [])
    (tmp_path / 'cut.mcap').write_bytes(head + packed[: len(packed) // 2])
    texts, (warning,) = read(tmp_path / 'cut.mcap')
    assert texts == TEXTS[1 : 1 + len(texts)]
    assert 7 <= len(texts) <= 10
    assert 'breaks off' in warning


def test_a_chunk_of_an_unknown_packing_is_named(tmp_path):
    content = flat_mcap([], end=False) + chunk(0, method='gzip')
    (tmp_path / 'bag.mcap').write_bytes(content)
    with pytest.raises(BagError, match="packed by 'gzip', expected lz4 or zstd"):
        BagReader(tmp_path / 'bag.mcap')


def test_chunks_without_an_index_of_their_messages_are_read(plain, tmp_path):
    whole = bytearray(plain.read_bytes())
    at = len(MAGIC)
    kept = bytearray(MAGIC)
    while at < len(whole) - len(MAGIC):
        size = 9 + int.from_bytes(whole[at + 1 : at + 9], 'little')
        kept += whole[at : at + size] if whole[at] in (1, 6, 15) else b''
        at += size
    (tmp_path / 'bag.mcap').write_bytes(kept + record(2, bytes(20)) + MAGIC)
    assert read(tmp_path / 'bag.mcap') == (TEXTS, [])


def test_chunk_indices_that_name_no_messages_hide_none(tmp_path):
    head = flat_mcap([], end=False)
    chunks = [chunk(index) for index in (0, 1)]
    out, indices = head, b''
    for index, content in enumerate(chunks):
        numbers = (index, index, len(out), len(content))
        fields = b''.join(number.to_bytes(8, 'little') for number in numbers)
        size = (len(content) - 9 - 40).to_bytes(8, 'little')
        indices += record(8, fields + bytes(4) + bytes(8) + string('') + size * 2)
        out += content
    out += record(15, bytes(4))
    schema_and_channel = head[head.index(b'\x03', len(MAGIC) + 9) :]
    footer = len(out).to_bytes(8, 'little') + bytes(12)
    out += schema_and_channel + indices + record(2, footer) + MAGIC
    (tmp_path / 'bag.mcap').write_bytes(out)
    assert read(tmp_path / 'bag.mcap') == (TEXTS[:2], [])


def test_topics_that_the_metadata_describes_in_another_way_are_not_lost(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write_text('/words', 'hello', 0)
    metadata = tmp_path / 'bag/metadata.yaml'
    metadata.write_text(metadata.read_text().replace('transient_local', 'volatile'))
    texts, (warning,) = read(tmp_path / 'bag')
    assert texts == ['hello']
    assert 'describes /words in another way' in warning


def killed_recorder(folder):
    """Write what a recorder leaves that is killed while the last texts are in its journal."""
    file = write_bag(folder / 'whole', StoragePlugin.SQLITE3)
    with closing(sqlite3.connect(file)) as database:
        database.execute('PRAGMA journal_mode = WAL')
        database.execute('PRAGMA wal_autocheckpoint = 0')
        row = (1, START_NS + COUNT * STEP_NS, data_of(COUNT))
        database.execute('INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)', row)
        database.commit()
        (folder / 'killed').mkdir()
        for each in file.parent.glob('*.db3*'):
            shutil.copy(each, folder / 'killed')
    return folder / 'killed'


def test_messages_in_a_journal_are_not_passed_over_in_silence(tmp_path):
    killed = killed_recorder(tmp_path)
    with pytest.raises(BagError, match='mctrack bag repair'):
        BagReader(killed)
