"""How bags are stored: chunks, splits, attachments; what is left of those that break off."""

import json
import shutil
import subprocess
import sys
import tracemalloc
import warnings

import numpy as np
import pytest
from mcap.reader import make_reader

from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagError, BagReader, BagWriter, Storage, attachments
from mctrack_ros.recording.bags.qos import reliable
from mctrack_ros.recording.bags.repair import repair_bag
from mctrack_ros.recording.track_log.log import SUMMARY, StoredLog

PACKED = Storage(is_packed=True)
STEP_NS = 10**8


def tracks(index):
    rng = np.random.default_rng(index)
    return Tracks.build(index * STEP_NS, position=rng.normal(size=(2, 3)), track_id=[1, index + 2])


def said(text):
    """Return the type of a text's message, and its bytes."""
    size = (len(text) + 1).to_bytes(4, 'little')
    return 'std_msgs/msg/String', b'\0\1\0\0' + size + text.encode() + b'\0'


def write(path, count, storage=PACKED):
    """Write a latched text and then tracks, each second of them flushed."""
    with BagWriter(path, storage=storage) as writer:
        writer.attach({'notes/one.txt': b'one'}, 'text/plain')
        writer.write_serialized('/site', *said('{'), 0, offered=[reliable(1, latched=True)])
        for index in range(count):
            writer.write_rows('/tracks', tracks(index), 'map')
            if index % 2:
                writer.flush()
    return path


def stamps(path):
    """Return the stamps of the tracks of a bag, or as far as it goes, and whether it is whole."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter('always')
        with BagReader(path) as reader:
            found = [rows.stamp_ns for rows, _ in reader.rows('/tracks', Tracks)]
    return found, not caught


ALL = [index * STEP_NS for index in range(12)]


@pytest.mark.parametrize('storage', [PACKED, Storage('sqlite3')], ids=['mcap', 'sqlite'])
def test_a_bag_is_read_by_this_package(tmp_path, storage):
    assert stamps(write(tmp_path / 'bag', 12, storage)) == (ALL, True)


def test_chunks_are_packed_and_the_mcap_package_reads_them(tmp_path):
    with (write(tmp_path / 'bag', 12) / 'bag.mcap').open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert len(summary.chunk_indexes) == 6
        assert {chunk.compression for chunk in summary.chunk_indexes} == {'zstd'}
        assert summary.statistics.message_count == 13
        sequences = [m.sequence for _, channel, m in reader.iter_messages() if channel.id == 2]
        assert sequences == list(range(12))
        assert 'serialized_metadata' in next(reader.iter_metadata()).metadata


@pytest.mark.parametrize(
    ('kind', 'limit'),
    [
        ('mcap', {'most_ns': 4 * STEP_NS}),
        ('mcap', {'most_bytes': 2500}),
        ('sqlite3', {'most_ns': 4 * STEP_NS}),
    ],
)
def test_each_file_of_a_split_bag_begins_with_what_is_latched(tmp_path, kind, limit):
    bag = write(tmp_path / 'bag', 12, Storage(kind, kind == 'mcap', **limit))
    files = sorted(bag.glob('bag_*'))
    assert len(files) > 1
    assert stamps(bag) == (ALL, True)
    found = []
    for file in files:
        with BagReader(file) as reader:
            topics = [topic for topic, *_ in reader.messages()]
            found += [rows.stamp_ns for rows, _ in reader.rows('/tracks', Tracks)]
        assert topics.count('/site') == 1
        assert topics[0] == '/site'
        assert attachments(file).get('notes/one.txt') == (b'one' if kind == 'mcap' else None)
    assert found == ALL
    with BagReader(bag) as reader:
        assert reader.count('/site') == len(files)
        assert reader.duration_s == pytest.approx(1.1)


def test_what_each_of_many_publishers_has_latched_begins_each_file(tmp_path):
    with BagWriter(tmp_path / 'bag', storage=Storage('mcap', True, most_ns=STEP_NS)) as bag:
        offered = []
        for camera in range(12):
            offered.append(reliable(1, latched=True))
            bag.write_serialized('/frames', *said(f'cam{camera:02}'), camera, offered=offered)
        for index in range(3):
            bag.write_rows('/tracks', tracks(index), 'map', 100 + index * STEP_NS)
    *_, last = sorted((tmp_path / 'bag').glob('bag_*'))
    with BagReader(last) as reader:
        names = [message.data for _, message, _ in reader.messages(['/frames'])]
    assert names == [f'cam{camera:02}' for camera in range(12)]


def test_finished_files_of_a_split_bag_take_no_memory(tmp_path):
    used = {}
    tracemalloc.start()
    with BagWriter(tmp_path / 'bag', storage=Storage('mcap', True, 30_000)) as bag:
        for index in range(1000):
            bag.write_rows('/tracks', tracks(index), 'map', index)
            bag.flush()
            used[index] = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert len(list((tmp_path / 'bag').glob('*.mcap'))) > 10
    assert used[999] - used[300] < 300_000


def test_a_bag_that_is_cut_anywhere_in_its_last_chunk_is_read_and_repaired_up_to_that_chunk(
    tmp_path,
):
    bag = write(tmp_path / 'bag', 3)
    whole = (bag / 'bag.mcap').read_bytes()
    with (bag / 'bag.mcap').open('rb') as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    begin, end = (
        chunks[-1].chunk_start_offset,
        chunks[-1].chunk_start_offset + chunks[-1].chunk_length,
    )
    assert end - begin < 10_000
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        for cut in range(begin, end + 1):
            (tmp_path / 'cut.mcap').write_bytes(whole[:cut])
            expected = ALL[:3] if cut == end else ALL[:2]
            assert stamps(tmp_path / 'cut.mcap') == (expected, False), cut
            if (end - cut) % 50 == 0:
                repair_bag(tmp_path / 'cut.mcap', tmp_path / 'mended', overwrite=True)
                assert stamps(tmp_path / 'mended') == (expected, True), cut
    assert attachments(tmp_path / 'mended')['notes/one.txt'] == b'one'
    logs = StoredLog.of(attachments(tmp_path / 'mended')).hashes
    assert logs == StoredLog.of(attachments(bag)).hashes


KILLED = """
import os, signal, sys
sys.path[:0] = sys.argv[2:]
from test_writer import BagWriter, PACKED, tracks
writer = BagWriter(sys.argv[1], storage=PACKED)
for index in range(7):
    writer.write_rows('/tracks', tracks(index), 'map')
    if index == 4:
        writer.flush()
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_was_flushed_survives_a_kill(tmp_path):
    subprocess.run([sys.executable, '-c', KILLED, tmp_path / 'bag', __file__.rpartition('/')[0]])
    assert stamps(tmp_path / 'bag') == (ALL[:5], False)


def test_a_bag_says_the_hash_of_its_tracks_and_who_made_it(tmp_path):
    bag = write(tmp_path / 'bag', 3)
    said = json.loads(attachments(bag)[SUMMARY])
    assert said['logs']['/tracks']['messages'] == 3
    assert len(said['logs']['/tracks']['sha256']) == 64
    assert said['made_by']['numpy'] == np.__version__
    assert write(tmp_path / 'again', 3) != bag
    assert attachments(tmp_path / 'again')[SUMMARY] == attachments(bag)[SUMMARY]


def test_a_full_disk_is_an_error_of_the_system(tmp_path):
    if not shutil.os.path.exists('/dev/full'):
        pytest.skip('there is no /dev/full')
    writer = BagWriter(tmp_path / 'bag')
    writer._files[-1]._stream.close()
    with open('/dev/full', 'wb', buffering=0) as full:
        writer._files[-1]._writer._Writer__stream = full
        writer.write_rows('/tracks', tracks(0), 'map')
        with pytest.raises(OSError, match='No space left'):
            writer.flush()


def test_an_empty_bag_is_finished_and_refused(tmp_path):
    BagWriter(tmp_path / 'bag', storage=PACKED).close()
    with pytest.raises(BagError, match='holds no messages'):
        BagReader(tmp_path / 'bag')
