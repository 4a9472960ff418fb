"""Definitions of message types from the files of their packages."""

import importlib
from pathlib import Path

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from std_msgs.msg import String

from mctrack_ros.recording.bags.definitions import known_definition
from mctrack_ros.ros.topics.definitions import definition_of, installed_definition


def installed_kinds(package):
    """Return the names of all messages of an installed package."""
    share = Path(importlib.import_module(package).__file__).parents[4] / 'share'
    return [f'{package}/msg/{file.stem}' for file in (share / package / 'msg').glob('*.msg')]


@pytest.mark.parametrize(
    'package', ['nav_msgs', 'sensor_msgs', 'visualization_msgs', 'lifecycle_msgs']
)
def test_every_installed_message_is_described_so_that_its_text_gives_its_hash(package):
    kinds = installed_kinds(package)
    assert kinds
    for kind in kinds:
        definition = installed_definition(kind)
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(definition.text, kind))
        assert store.hash_rihs01(kind) == definition.type_hash, kind


def test_what_publishers_announce_chooses_the_definition():
    kind = f'std_msgs/msg/{String.__name__}'
    announced = known_definition(kind).type_hash
    assert definition_of(kind, [announced]).type_hash == announced
    assert definition_of(kind, []) == installed_definition(kind)


def test_another_definition_than_the_installed_one_is_refused():
    with pytest.raises(ValueError, match='another definition of std_msgs/msg/String'):
        definition_of('std_msgs/msg/String', [f'RIHS01_{1:064}'])


def test_a_type_that_nobody_describes_is_named():
    with pytest.raises(ValueError, match='define acme_msgs/msg/Gadget are not installed'):
        definition_of('acme_msgs/msg/Gadget', [])
