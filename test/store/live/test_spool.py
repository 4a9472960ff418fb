"""The spool gives back what was saved, whatever ended the process, and keeps its limit."""

import errno
import os

import pytest

from mctrack_ros.store import StoreError
from mctrack_ros.store.live.spool import FILE_BYTES, Spool

SITE = '/site'


def opened(folder, limit=0):
    return Spool(folder, limit, SITE)


def abandoned(spool):
    """Let go of a spool as a killed process does."""
    spool._guard.close()


def put(spool, count, size=10):
    for _ in range(count):
        spool.put('/tracks', 7, os.urandom(size))


def numbers(spool):
    found = []
    while records := spool.read():
        found += [record.number for record in records if record.topic != SITE]
    return found


def test_records_come_back_in_order_and_once(tmp_path):
    spool = opened(tmp_path)
    for k in range(5):
        spool.put('/tracks', 100 + k, b'%d' % k)
    assert spool.read() == []
    spool.save()
    found = spool.read()
    assert [(r.number, r.topic, r.log_ns, r.data) for r in found] == [
        (k + 1, '/tracks', 100 + k, b'%d' % k) for k in range(5)
    ]
    assert spool.read() == []
    spool.put('/events', 200, b'')
    spool.save()
    assert [record.topic for record in spool.read()] == ['/events']
    assert spool.waiting == 6
    spool.free(6)
    assert spool.waiting == 0


def test_what_was_saved_outlives_the_process(tmp_path):
    first = opened(tmp_path)
    put(first, 3)
    first.save()
    put(first, 2)
    abandoned(first)
    again = opened(tmp_path)
    assert again.source == first.source
    assert numbers(again) == [1, 2, 3]
    put(again, 1)
    again.save()
    assert numbers(again) == [4]


@pytest.mark.parametrize('cut', [1, 20, 40])
def test_a_frame_that_was_not_finished_is_cut_off(tmp_path, cut):
    spool = opened(tmp_path)
    put(spool, 3)
    spool.save()
    put(spool, 2)
    spool.save()
    abandoned(spool)
    (path,) = tmp_path.glob('*.spool')
    os.truncate(path, path.stat().st_size - cut)
    again = opened(tmp_path)
    put(again, 1)
    again.save()
    assert numbers(again) == [1, 2, 3, 4]
    assert again.dropped == 0


def test_a_damaged_file_loses_what_follows_in_it_and_says_how_much(tmp_path):
    spool = opened(tmp_path)
    put(spool, 4)
    spool.save()
    put(spool, 4, FILE_BYTES // 3)
    spool.save()
    put(spool, 4)
    spool.save()
    first, _ = sorted(tmp_path.glob('*.spool'))
    data = bytearray(first.read_bytes())
    data[-100] ^= 1
    first.write_bytes(data)
    assert numbers(spool) == [1, 2, 3, 4, 9, 10, 11, 12]
    assert spool.dropped == 4
    spool.rewind(0)
    numbers(spool)
    assert spool.dropped == 4


def test_the_oldest_are_dropped_beyond_the_limit_and_counted(tmp_path):
    spool = opened(tmp_path, 4 * FILE_BYTES)
    for _ in range(40):
        put(spool, 10, FILE_BYTES // 40)
        spool.save()
    assert spool.size <= 4 * FILE_BYTES
    found = numbers(spool)
    assert found == list(range(401 - len(found), 401))
    assert spool.dropped == 400 - len(found) > 0
    spool.free(400)
    assert len(list(tmp_path.glob('*.spool'))) == 1


def test_every_file_begins_with_the_last_latched_message(tmp_path):
    spool = opened(tmp_path)
    spool.put(SITE, 1, b'old')
    spool.put(SITE, 2, b'new')
    for _ in range(3):
        put(spool, 1, FILE_BYTES)
        spool.save()
    files = sorted(tmp_path.glob('*.spool'))
    assert len(files) == 3
    spool.free(3)
    spool.rewind(3)
    records = spool.read()
    assert [(r.number, r.data) for r in records if r.topic == SITE] == [(2, b'new')]
    abandoned(spool)
    again = opened(tmp_path)
    put(again, 1)
    again.save()
    again.free(5)
    again.rewind(5)
    assert next((r.number, r.data[:3]) for r in again.read()) == (2, b'new')


def test_nothing_that_is_freed_stays_after_the_end(tmp_path):
    spool = opened(tmp_path)
    spool.put(SITE, 1, b'site')
    put(spool, 5, 1000)
    spool.save()
    numbers(spool)
    spool.free(6)
    spool.close()
    assert sum(path.stat().st_size for path in tmp_path.glob('*.spool')) < 200
    again = opened(tmp_path)
    put(again, 1)
    again.save()
    again.rewind(6)
    assert numbers(again) == [7]


def test_records_wait_in_memory_while_the_disk_is_full(tmp_path, monkeypatch):
    spool = opened(tmp_path)
    put(spool, 2)
    spool.save()

    def full(*_):
        raise OSError(errno.ENOSPC, 'No space left on device')

    with monkeypatch.context() as patched:
        patched.setattr(spool, '_append', full)
        put(spool, 2)
        spool.save()
        assert 'No space left' in spool.failure
        assert numbers(spool) == [1, 2, 3, 4]
        spool.free(3)
        put(spool, 1)
        spool.save()
        assert numbers(spool) == [5]
    spool.save()
    assert spool.failure == ''
    spool.rewind(3)
    assert numbers(spool) == [4, 5]
    assert spool.dropped == 0


def test_one_process_at_a_time_has_a_spool(tmp_path):
    spool = opened(tmp_path)
    with pytest.raises(StoreError, match='in use by another process'):
        opened(tmp_path)
    spool.close()
    opened(tmp_path).close()


def test_a_spool_whose_files_are_gone_is_another(tmp_path):
    """It counts from 1: the database must not take what comes for what it has."""
    spool = opened(tmp_path)
    put(spool, 3)
    spool.close()
    for path in tmp_path.glob('*.spool'):
        path.unlink()
    assert opened(tmp_path).source != spool.source
