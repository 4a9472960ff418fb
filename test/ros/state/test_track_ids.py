"""Ids that are used once: what the file says, and what is refused."""

import json
import os
from pathlib import Path

import pytest

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion.management.initiation import MOST_STARTS
from mctrack_ros.ros.state.track_ids import TrackIds, state_path


@pytest.fixture
def path(tmp_path):
    return tmp_path / 'below' / 'fusion.json'


def next_id_in(path):
    return json.loads(path.read_text())['next_id']


def test_the_first_run_begins_at_1_and_the_next_where_it_ended(path):
    ids = TrackIds(path)
    assert ids.first == 1
    ids.keep_ahead(7)
    ids.close(7)
    assert TrackIds(path).first == 7


def test_the_file_is_always_ahead_of_what_a_tick_may_use(path):
    ids = TrackIds(path)
    for next_id in range(1, 20_000, MOST_STARTS):
        ids.keep_ahead(next_id)
        assert next_id_in(path) >= next_id + MOST_STARTS


def test_the_file_is_written_for_blocks_of_ids_and_not_each_tick(path):
    ids, written = TrackIds(path), set()
    for next_id in range(1, 2000):
        ids.keep_ahead(next_id)
        written.add(next_id_in(path))
    assert len(written) <= 4


def test_a_write_that_breaks_off_leaves_the_old_file(path, monkeypatch):
    ids = TrackIds(path)
    before = next_id_in(path)

    def full(descriptor):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(os, 'fsync', full)
    with pytest.raises(OSError, match='No space left'):
        ids.keep_ahead(before)
    assert next_id_in(path) == before
    assert 'No space left' in ids.report('ids').message
    monkeypatch.undo()
    ids.keep_ahead(before)
    assert next_id_in(path) > before
    assert ids.report('ids').message == 'ids are never used twice'


def test_two_nodes_do_not_share_a_file_until_one_gives_it_up(path):
    ids = TrackIds(path)
    with pytest.raises(ConfigError, match=rf'in use by another .*process {os.getpid()}\)'):
        TrackIds(path)
    ids.close(5)
    assert TrackIds(path).first == 5


@pytest.mark.parametrize('text', ['', '[]', '{}', '{"next_id": "7"}', '{"next_id": 0}', '7'])
def test_a_file_that_says_no_id_is_refused_and_kept(path, text):
    path.parent.mkdir()
    path.write_text(text)
    with pytest.raises(ConfigError, match='holds no next_id: delete it'):
        TrackIds(path)
    assert path.read_text() == text
    path.write_text('{"next_id": 3}')
    assert TrackIds(path).first == 3


def test_a_place_that_cannot_be_written_to_is_refused_with_a_reason(tmp_path):
    (tmp_path / 'file').touch()
    with pytest.raises(ConfigError, match=r'file/x/y.json: Not a directory: .* used twice'):
        TrackIds(tmp_path / 'file' / 'x' / 'y.json')


def test_a_run_that_would_begin_in_the_upper_half_of_ids_begins_at_1_again(path):
    path.parent.mkdir()
    path.write_text(json.dumps({'next_id': 2**31 + 1}))
    ids = TrackIds(path)
    assert ids.first == 1
    assert ids.began_again


def test_each_node_of_each_domain_has_a_file_of_its_own(monkeypatch, tmp_path):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    of = {
        (domain, node): state_path('auto', domain, node)
        for domain in (0, 7)
        for node in ('/fusion', '/hall/fusion', '/hall_fusion')
    }
    assert len(set(of.values())) == 6
    assert of[7, '/hall/fusion'] == tmp_path / 'mctrack_ros/domain_7/hall/fusion.json'
    monkeypatch.delenv('ROS_HOME')
    monkeypatch.setenv('HOME', '/home/somebody')
    at_home = Path('/home/somebody/.ros/mctrack_ros/domain_0/fusion.json')
    assert state_path('auto', 0, '/fusion') == at_home


def test_a_path_that_is_given_is_taken(monkeypatch, tmp_path):
    monkeypatch.setenv('HOME', str(tmp_path))
    monkeypatch.chdir(tmp_path)
    assert state_path('~/ids.json', 0, '/fusion') == tmp_path / 'ids.json'
    assert state_path('ids.json', 0, '/fusion') == tmp_path / 'ids.json'
    assert state_path('', 0, '/fusion') is None
