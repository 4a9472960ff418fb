"""`mctrack bag repair`, and commands on bags that break off, as a user runs them."""

import shutil
import sqlite3
import warnings
from contextlib import closing

import pytest
from typer.testing import CliRunner

from mctrack_ros.cli.main import app
from mctrack_ros.interfaces import Detections, Events
from mctrack_ros.recording import BagReader, BagWriter
from mctrack_ros.recording.definitions import TypeDefinition
from mctrack_ros.recording.qos import reliable


@pytest.fixture
def bag(tmp_path):
    """Return a bag of four seconds of detections, with a site said once and a type of its own."""
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write_text('/site', '{}', 0)
        writer.write_serialized('/odd', 'acme/msg/Gadget', b'\0\1\0\0' + bytes(4), 1, ODD)
        for index in range(1, 400):
            stamp_ns = index * 10**7
            rows = Detections.build(stamp_ns, position=[[index, 2.0, 0.0]] * 40)
            writer.write_rows('/cam1/detections', rows, 'map')
            writer.write_rows('/cam1/events', Events.build(stamp_ns), 'map')
    return tmp_path / 'bag'


ODD = TypeDefinition('int32 wheels\n', '')


def repair(*arguments):
    """Run the command; return its output and what was warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter('always')
        result = CliRunner().invoke(app, ['bag', 'repair', *map(str, arguments)])
    assert result.exit_code == 0, result.exception
    return result.output, [str(warning.message) for warning in caught]


def serialized(path):
    with BagReader(path) as reader:
        return list(reader.serialized())


def test_a_cut_bag_becomes_a_finished_one_with_types_and_quality_of_service(bag, tmp_path):
    (file,) = bag.glob('*.mcap')
    whole = serialized(bag)
    file.write_bytes(file.read_bytes()[: int(0.7 * file.stat().st_size)])
    output, (warning,) = repair(file, tmp_path / 'new')
    assert 'breaks off' in warning
    messages = serialized(tmp_path / 'new')
    assert 400 < len(messages) < len(whole)
    assert messages == whole[: len(messages)]
    seconds = (messages[-1][-1] - messages[0][-1]) * 1e-9
    assert f'{len(messages)} messages, {seconds:.3f} s' in output
    with BagReader(tmp_path / 'new') as reader:
        assert reader.offered('/cam1/events') == [reliable(100)]
        assert reader.offered('/site') == [reliable(1, latched=True)]
        assert reader.definition('/odd').text == ODD.text
        (odd,) = (message for _, message, _ in reader.messages(['/odd']))
        assert odd.wheels == 0


def test_messages_in_the_journal_of_a_killed_recorder_are_kept(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    types, kind = get_typestore(Stores.ROS2_JAZZY), 'std_msgs/msg/String'
    with Writer(tmp_path / 'whole', version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection('/words', kind, typestore=types)
        writer.write(connection, 5, b'first')
    killed = tmp_path / 'killed'
    killed.mkdir()
    with closing(sqlite3.connect(tmp_path / 'whole/whole.db3')) as database:
        database.execute('PRAGMA journal_mode = WAL')
        database.execute(
            'INSERT INTO messages (topic_id, timestamp, data) VALUES (1, 6, zeroblob(9))'
        )
        database.commit()
        for file in (tmp_path / 'whole').glob('*.db3*'):
            shutil.copy(file, killed)
    before = {file.name: file.read_bytes() for file in killed.iterdir()}
    assert len(before) > 1
    repair(killed, tmp_path / 'new')
    assert [time_ns for *_, time_ns in serialized(tmp_path / 'new')] == [5, 6]
    assert {file.name: file.read_bytes() for file in killed.iterdir()} == before


def test_a_bag_is_not_repaired_in_its_own_place(bag):
    result = CliRunner().invoke(app, ['bag', 'repair', str(bag), str(bag), '--overwrite'])
    assert 'choose another name' in str(result.exception)
    assert serialized(bag)
