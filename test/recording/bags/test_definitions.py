"""Messages are decoded by what their bag says of their types."""

import pytest

from mctrack_ros.recording import BagError, BagReader, BagWriter
from mctrack_ros.recording.bags.definitions import TypeDefinition, known_definition

HEAD = b'\0\1\0\0'
FIVE = (5).to_bytes(4, 'little')


def only_message(path, kind, data, definition):
    with BagWriter(path) as writer:
        writer.write_serialized('/x', kind, HEAD + data, 0, definition)
    with BagReader(path) as reader:
        ((_, message, _),) = reader.messages(['/x'])
    return message


def test_a_type_that_only_the_bag_defines_is_decoded(tmp_path):
    text = f'acme/Wheel[] wheels\n{"=" * 80}\nMSG: acme/Wheel\nint32 spokes\n'
    one = (1).to_bytes(4, 'little')
    message = only_message(tmp_path / 'bag', 'acme/msg/Cart', one + FIVE, TypeDefinition(text, ''))
    assert [wheel.spokes for wheel in message.wheels] == [5]


def test_a_known_type_of_another_definition_is_decoded_by_the_bags(tmp_path):
    other = TypeDefinition('int32 number\n', f'RIHS01_{1:064}')
    assert only_message(tmp_path / 'bag', 'std_msgs/msg/String', FIVE, other).number == 5
    (file,) = (tmp_path / 'bag').glob('*.mcap')
    with BagReader(file) as reader:
        ((_, message, _),) = reader.messages(['/x'])
    assert message.number == 5


def test_idl_definitions_are_read(tmp_path):
    bodies = {'Cart': 'acme::msg::Wheel wheel;', 'Wheel': 'long spokes;'}
    text = ''.join(
        f'{"=" * 80}\nIDL: acme/msg/{name}\n// generated\n'
        f'module acme {{ module msg {{ struct {name} {{ {body} }}; }}; }};\n'
        for name, body in bodies.items()
    )
    definition = TypeDefinition(text, '')
    message = only_message(tmp_path / 'bag', 'acme/msg/Cart', FIVE, definition)
    assert message.wheel.spokes == 5


def test_two_definitions_of_a_type_in_one_bag_are_refused(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write_serialized(
            '/a', 'acme/msg/Cart', HEAD + FIVE, 0, TypeDefinition('int32 n', '')
        )
        with pytest.raises(BagError, match='/b has another definition'):
            writer.write_serialized('/b', 'acme/msg/Cart', HEAD, 0, TypeDefinition('int8 n', ''))


def test_a_type_that_nobody_defines_is_named(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write_serialized('/x', 'acme/msg/Cart', HEAD, 0, TypeDefinition('nonsense !', ''))
    with BagReader(tmp_path / 'bag') as reader, pytest.raises(BagError, match='acme/msg/Cart'):
        list(reader.messages(['/x']))


def test_known_types_are_described(tmp_path):
    definition = known_definition('sensor_msgs/msg/PointCloud2')
    assert 'MSG: sensor_msgs/PointField' in definition.text
    assert definition.type_hash.startswith('RIHS01_')
    assert known_definition('acme/msg/Cart') is None
