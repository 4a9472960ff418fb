"""The spool gives back what was saved, whatever ended the process, and keeps its limit."""

import os
import shutil

import pytest

from mctrack_ros.store import StoreError
from mctrack_ros.store.live.spool import LEAST_BYTES, Spool

SITE = '/site'


def opened(folder, limit=0):
    return Spool(folder, limit, SITE)


def copied(folder, name):
    """Return the spool that the next process finds when this one is killed now."""
    shutil.copytree(folder, folder.parent / name)
    return opened(folder.parent / name)


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
    first = opened(tmp_path / 'spool')
    put(first, 3)
    first.save()
    put(first, 2)
    again = copied(tmp_path / 'spool', 'copy')
    assert again.source == first.source
    assert numbers(again) == [1, 2, 3]
    put(again, 1)
    again.save()
    assert numbers(again) == [4]


@pytest.mark.parametrize('cut', [1, 20, 400, 4000])
def test_a_write_that_was_not_finished_is_cut_off(tmp_path, cut):
    spool = opened(tmp_path / 'killed')
    put(spool, 3)
    spool.save()
    spool.synchronise()
    put(spool, 2)
    spool.save()
    shutil.copytree(tmp_path / 'killed', tmp_path / 'copy')
    log = tmp_path / 'copy' / 'spool.db-wal'
    os.truncate(log, log.stat().st_size - cut)
    again = opened(tmp_path / 'copy')
    put(again, 1)
    again.save()
    assert numbers(again) == [1, 2, 3, 4]
    assert again.dropped == 0


def test_a_damaged_file_is_refused(tmp_path):
    spool = opened(tmp_path)
    put(spool, 400)
    spool.close()
    path = tmp_path / 'spool.db'
    path.write_bytes(b'x' * path.stat().st_size)
    with pytest.raises(StoreError, match=r'spool.db is damaged: move it away'):
        opened(tmp_path)


def test_the_oldest_are_dropped_beyond_the_limit_and_counted(tmp_path):
    spool = opened(tmp_path, LEAST_BYTES)
    spool.put(SITE, 1, b'site')
    for _ in range(40):
        put(spool, 10, LEAST_BYTES // 160)
        spool.save()
        assert spool.size <= LEAST_BYTES
    spool.rewind(0)
    site, *records = spool.read()
    assert (site.number, site.data) == (1, b'site')
    found = [record.number for record in records]
    assert found == list(range(402 - len(found), 402))
    assert len(found) > 100
    assert spool.dropped == 401 - len(found) == 401 - spool.waiting
    spool.free(401)
    assert spool.size < 1 << 16
    assert spool.waiting == 0


def test_the_last_latched_message_comes_before_what_follows(tmp_path):
    spool = opened(tmp_path / 'spool')
    spool.put(SITE, 1, b'old')
    spool.put(SITE, 2, b'new')
    put(spool, 3)
    spool.save()
    assert [record.number for record in spool.read()] == [1, 2, 3, 4, 5]
    spool.free(3)
    for each in (spool, copied(tmp_path / 'spool', 'copy')):
        each.rewind(3)
        records = each.read()
        assert [record.number for record in records] == [2, 4, 5]
        assert records[0].data == b'new'
        assert each.read() == []


def test_nothing_that_is_freed_stays_after_the_end(tmp_path):
    spool = opened(tmp_path)
    spool.put(SITE, 1, b'site')
    for _ in range(5):
        spool.put('/tracks', 7, b'somebody')
    spool.save()
    numbers(spool)
    spool.free(6)
    spool.close()
    assert all(b'somebody' not in path.read_bytes() for path in tmp_path.iterdir())
    again = opened(tmp_path)
    put(again, 1)
    again.save()
    again.rewind(6)
    assert numbers(again) == [7]


def test_records_wait_in_memory_while_the_disk_is_full(tmp_path):
    spool = opened(tmp_path)
    put(spool, 2)
    spool.save()
    pages = spool._file.execute('PRAGMA page_count').fetchone()[0]
    spool._file.execute(f'PRAGMA max_page_count = {pages}')  # SQLite says that the disk is full
    put(spool, 2, 1 << 16)
    spool.save()
    assert 'full' in spool.failure
    assert numbers(spool) == [1, 2, 3, 4]
    spool.free(3)
    put(spool, 1, 1 << 16)
    spool.save()
    assert 'full' in spool.failure
    assert numbers(spool) == [5]
    spool._file.execute('PRAGMA max_page_count = 1000000')
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
    (tmp_path / 'spool.db').unlink()
    assert opened(tmp_path).source != spool.source
