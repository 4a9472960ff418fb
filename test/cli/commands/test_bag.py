"""`mctrack bag repair`, and commands on bags that break off, as a user runs them."""

import json
import random
import re
import shutil
import sqlite3
import warnings
from contextlib import closing
from pathlib import Path

import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from typer.testing import CliRunner

from mctrack_ros.cli.main import app
from mctrack_ros.cli.sites import named_site
from mctrack_ros.interfaces import Detections, Events
from mctrack_ros.recording import BagReader, BagWriter
from mctrack_ros.recording.bags.definitions import TypeDefinition
from mctrack_ros.recording.bags.qos import reliable
from mctrack_ros.replay.track import track_bag
from rewritten_bag import flipped, part_of, rewritten


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


def second_chunk(data):
    """Return where the second packed chunk of an MCAP file begins."""
    magic = bytes.fromhex('28b52ffd')
    return data.index(magic, data.index(magic) + 1)


def middle_leaf(data):
    """Return where a page in the middle of an SQLite file holds rows of a table."""
    pages = range(4096 * (len(data) // 8192), len(data), 4096)
    return next(at for at in pages if data[at] == 0x0D)


@pytest.mark.parametrize(
    ('plugin', 'damaged'),
    [(StoragePlugin.MCAP, second_chunk), (StoragePlugin.SQLITE3, middle_leaf)],
)
@pytest.mark.parametrize('by_file', [True, False])
def test_what_is_damaged_in_the_middle_is_said_and_the_rest_is_kept(
    tmp_path, plugin, damaged, by_file
):
    types, kind = get_typestore(Stores.ROS2_JAZZY), 'std_msgs/msg/String'
    writer = Writer(tmp_path / 'bag', version=9, storage_plugin=plugin)
    if plugin is StoragePlugin.MCAP:
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection('/words', kind, typestore=types)
        for index in range(200):
            word = types.types[kind](data=f'{index} ' + random.Random(index).randbytes(9000).hex())
            writer.write(connection, index * 10**8, types.serialize_cdr(word, kind))
    whole = serialized(tmp_path / 'bag')
    (file,) = (each for each in (tmp_path / 'bag').iterdir() if each.suffix != '.yaml')
    data = bytearray(file.read_bytes())
    at = damaged(data)
    data[at : at + 4] = b'\xff' * 4
    file.write_bytes(data)
    output, (warning,) = repair(file if by_file else file.parent, tmp_path / 'new')
    kept = serialized(tmp_path / 'new')
    lost = [index for index, each in enumerate(whole) if each not in kept]
    assert kept == [each for index, each in enumerate(whole) if index not in lost]
    assert 0 < len(lost) < 100
    assert len(whole) - 1 not in lost
    begin_s, end_s = map(float, re.search(r'lost, ([.\d]+) to ([.\d]+) s after', warning).groups())
    assert f'{file.name} is damaged: {len(lost)} messages are lost' in warning
    assert begin_s <= lost[0] / 10 <= lost[-1] / 10 <= end_s < begin_s + (len(lost) + 2) / 10
    assert f'{len(kept)} messages' in output


def test_a_bag_is_not_repaired_in_its_own_place(bag):
    result = CliRunner().invoke(app, ['bag', 'repair', str(bag), str(bag), '--overwrite'])
    assert 'choose another name' in str(result.exception)
    assert serialized(bag)


def test_a_bag_is_described(bag):
    result = CliRunner().invoke(app, ['bag', 'info', str(bag)])
    assert result.exit_code == 0, result.exception
    assert '800 messages, 3.990 s' in result.output
    assert re.search('/cam1/detections +sensor_msgs/msg/PointCloud2 +399 +100.00', result.output)
    said = json.loads(CliRunner().invoke(app, ['bag', 'info', str(bag), '--json']).output)
    assert said['topics']['/odd'] | {'rate': 0} == {
        'type': 'acme/msg/Gadget',
        'messages': 1,
        'rate': 0,
        'lost': None,
    }
    assert said['attachments'].keys() == {'mctrack/track_log.json', 'mctrack/checksums/000000'}
    assert said['made_by']['mctrack_ros']


def test_a_replay_is_verified_and_gone_on_with(tmp_path):
    folder = Path(__file__).resolve().parents[3] / 'bags/pitch5_detections'
    bag = part_of(folder, tmp_path / 'bag', 1.0, 1.6)
    out, state = str(tmp_path / 'out'), str(tmp_path / 'state')
    track_bag(bag, out, named_site('pitch5'), processes=1)
    said = CliRunner().invoke(
        app, ['replay', out, '--verify', '--until', '0.2', '--save-state', state]
    )
    assert said.exit_code == 0, said.exception
    assert said.output.startswith('same: 6 ticks')
    said = CliRunner().invoke(app, ['replay', out, '--verify', '--from-state', state])
    assert said.exit_code == 0, said.exception
    assert re.match('same: 9 ticks, .* as stored; .* times real time', said.output)
    wrong = rewritten(
        tmp_path / 'out/bag',
        tmp_path / 'wrong.mcap',
        lambda topic, number, data: flipped(data, 'x', 0, 3) if topic == '/tracks' else data,
    )
    said = CliRunner().invoke(app, ['replay', str(wrong), '--verify'])
    assert said.exit_code == 1
    assert said.output.startswith('differs: tick 0 at 0.000 s, x of track')
