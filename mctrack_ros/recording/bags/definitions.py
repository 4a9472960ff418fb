"""How message types are defined: in the store of rosbags, or as a bag says."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rosbags.interfaces import Connection, MessageDefinitionFormat
from rosbags.typesys import (
    Stores,
    TypesysError,
    get_types_from_idl,
    get_types_from_msg,
    get_typestore,
)
from rosbags.typesys.store import Typestore

_IDL_HEAD = re.compile('={80}\nIDL: .*\n')
TYPES = get_typestore(Stores.ROS2_JAZZY)
"""The types that rosbags knows."""
NO_HASH = f'RIHS00_{0:064}'
"""Of a type whose hash nobody knows; readers want one."""


@dataclass(frozen=True, slots=True)
class TypeDefinition:
    """
    A message type as a bag describes it.

    Attributes
    ----------
    text : str
        Its ``.msg`` or ``.idl`` files and those of all types within.
    type_hash : str
        ``RIHS01_...``; empty: not known.

    """

    text: str
    type_hash: str

    @property
    def encoding(self) -> str:
        """How bags call the language of the text."""
        return 'ros2idl' if _IDL_HEAD.match(self.text) else 'ros2msg'


def known_definition(kind: str) -> TypeDefinition | None:
    """Return the definition of a type that rosbags knows."""
    if kind not in TYPES.types:
        return None
    return TypeDefinition(TYPES.generate_msgdef(kind, ros_version=2)[0], TYPES.hash_rihs01(kind))


def stated_definition(connection: Connection) -> TypeDefinition | None:
    """Return the definition that a bag holds of a topic's type; None: it holds none."""
    if connection.msgdef.format is MessageDefinitionFormat.NONE or not connection.msgdef.data:
        return None
    type_hash = connection.digest
    if not type_hash:
        store = _store(connection)
        type_hash = '' if store is None else _hash(store, connection.msgtype)
    return TypeDefinition(connection.msgdef.data, type_hash)


def types_for(connection: Connection) -> Typestore | None:
    """Return types by which a topic's messages are decoded; None: its type is not known."""
    kind = connection.msgtype
    known, stated = known_definition(kind), stated_definition(connection)
    if known and (
        stated is None or stated.text == known.text or stated.type_hash in ('', known.type_hash)
    ):
        return TYPES
    return None if stated is None else _store(connection)


def _store(connection: Connection) -> Typestore | None:
    """Return the types that a bag defines for a topic; None: rosbags cannot read them."""
    text, store = connection.msgdef.data, get_typestore(Stores.EMPTY)
    try:
        if connection.msgdef.format is MessageDefinitionFormat.IDL:
            for part in filter(None, _IDL_HEAD.split(text)):
                store.register(get_types_from_idl(part))
        else:
            store.register(get_types_from_msg(text, connection.msgtype))
    except (TypesysError, KeyError, ValueError):
        return None
    return store if connection.msgtype in store.types else None


def _hash(store: Typestore, kind: str) -> str:
    try:
        return store.hash_rihs01(kind)
    except KeyError:  # a string type that rosbags does not hash
        return ''
