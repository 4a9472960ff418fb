"""
Message types that are not installed, made from their definitions: for serialised messages.

The wheels of rclpy lack ``tf2_msgs``. Publishers and subscriptions of serialised messages ask a
type for its name, its hash, its fields and how long it may become, and for nothing else: for a
message that holds nothing but a sequence of an installed one, Fast DDS's support of another such
message lends the rest. Where the real package is installed, it is used.
"""

from __future__ import annotations

import ctypes
import importlib
from pathlib import Path
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore
from visualization_msgs.msg import MarkerArray

from mctrack_ros.ros.topics.messages import message_class

TYPES = get_typestore(Stores.ROS2_JAZZY)
_LENDER = 'visualization_msgs/msg/MarkerArray'
_FAST, _FIELDS = 'rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_introspection_c'
_KEPT: list[Any] = []
"""What C code points to: it must never move or end."""
_Text, _Pointer, _Size = ctypes.c_char_p, ctypes.c_void_p, ctypes.c_size_t


class _Support(ctypes.Structure):
    """``rosidl_message_type_support_t`` of Jazzy."""

    _fields_ = (
        ('identifier', _Text), ('data', _Pointer), ('handle', _Pointer), ('hash', _Pointer),
        ('description', _Pointer), ('sources', _Pointer),
    )  # fmt: skip


class _Callbacks(ctypes.Structure):
    """``message_type_support_callbacks_t`` of Fast DDS: names, then functions."""

    _fields_ = (('namespace', _Text), ('name', _Text), ('functions', _Pointer * 5))


class _Member(ctypes.Structure):
    """``rosidl_typesupport_introspection_c__MessageMember``."""

    _fields_ = (
        ('name', _Text), ('kind', ctypes.c_uint8), ('bound', _Size), ('members', _Pointer),
        ('is_key', ctypes.c_bool), ('is_array', ctypes.c_bool), ('size', _Size),
        ('is_bound', ctypes.c_bool), ('offset', ctypes.c_uint32), ('functions', _Pointer * 7),
    )  # fmt: skip


class _Members(ctypes.Structure):
    """``rosidl_typesupport_introspection_c__MessageMembers``."""

    _fields_ = (
        ('namespace', _Text), ('name', _Text), ('count', ctypes.c_uint32), ('size', _Size),
        ('has_key', ctypes.c_bool), ('members', ctypes.POINTER(_Member)), ('begin', _Pointer),
        ('end', _Pointer),
    )  # fmt: skip


class _Hash(ctypes.Structure):
    """``rosidl_type_hash_t``."""

    _fields_ = (('version', ctypes.c_uint8), ('value', ctypes.c_uint8 * 32))


_Choose = ctypes.CFUNCTYPE(_Pointer, _Pointer, _Text)
_Ask = ctypes.CFUNCTYPE(_Pointer, _Pointer)


def serialisable(kind: str) -> Any:
    """
    Return the class of a message type: the installed one, or one for serialised messages alone.

    Raises
    ------
    ValueError
        If it is not installed and cannot be made here.

    """
    try:
        return message_class(kind)
    except ValueError:
        return _made(kind)


def serialised(kind: str, **fields: Any) -> bytes:
    """Return a message of a type that rosbags knows, of rosbags' own messages, as bytes."""
    return bytes(TYPES.serialize_cdr(TYPES.types[kind](**fields), kind))


def _made(kind: str) -> Any:
    """Make the class of a message that is a sequence of an installed one."""
    (field, element), package = _sequence(kind), kind.split('/')[0]
    fast, fields = (_lent(support, _LENDER) for support in (_FAST, _FIELDS))
    callbacks = _Callbacks.from_buffer_copy(_at(fast, _Callbacks))
    members = _Members.from_buffer_copy(_at(fields, _Members))
    if (callbacks.namespace, callbacks.name, members.count) != (
        b'visualization_msgs::msg', b'MarkerArray', 1,
    ):  # fmt: skip
        raise ValueError(f'message type {kind!r} is not installed, and cannot be made here')
    name = kind.split('/')[-1]
    callbacks.namespace, callbacks.name = f'{package}::msg'.encode(), name.encode()
    member = _Member.from_buffer_copy(members.members.contents)
    member.name, nested = field.encode(), _lent(_FIELDS, element)
    member.members = ctypes.addressof(nested)
    members.namespace, members.name = f'{package}__msg'.encode(), name.encode()
    members.members = ctypes.pointer(member)
    capsule = _capsule(fast, fields, callbacks, members, kind)
    _KEPT.extend((callbacks, members, member, nested))
    lender: Any = type(MarkerArray)
    if lender._TYPE_SUPPORT is None:
        lender.__import_type_support__()
    made = type(f'Metaclass_{name}', (lender,), {'_TYPE_SUPPORT': capsule})
    described = {field: f'sequence<{element.replace("/msg/", "/")}>'}
    content = {
        '__module__': f'{package}.msg',
        '__slots__': (),
        'get_fields_and_field_types': classmethod(lambda cls: described),
    }
    return made(name, (), content)


def _capsule(
    fast: _Support, fields: _Support, callbacks: _Callbacks, members: _Members, kind: str
) -> Any:
    """Return what rclpy takes for the support of a type: it chooses by the name of a support."""
    digest = bytes.fromhex(TYPES.hash_rihs01(kind).removeprefix('RIHS01_'))
    hashed = _Hash(1, (ctypes.c_uint8 * 32)(*digest))
    ask = _Ask(lambda _: ctypes.addressof(hashed))
    own = []
    for lent, data in ((fast, callbacks), (fields, members)):
        support = _Support.from_buffer_copy(lent)
        support.data, support.hash = ctypes.addressof(data), ctypes.cast(ask, _Pointer).value
        own.append(support)
    by_name = {support.identifier: ctypes.addressof(support) for support in own}
    choose = _Choose(lambda _, identifier: by_name.get(identifier))
    whole = _Support.from_buffer_copy(own[0])
    whole.identifier, whole.handle = b'made', ctypes.cast(choose, _Pointer).value
    _KEPT.extend((hashed, ask, own, choose, whole))
    new = ctypes.pythonapi.PyCapsule_New
    new.restype, new.argtypes = ctypes.py_object, (_Pointer, _Text, _Pointer)
    return new(ctypes.addressof(whole), None, None)


def _sequence(kind: str) -> tuple[str, str]:
    """Return the name of the one field of a type, and the type that it is a sequence of."""
    if kind not in TYPES.types:
        raise ValueError(f'message type {kind!r} is neither installed nor known')
    described: Any = TYPES.fielddefs[kind][1]
    name, (node, content) = described[0]
    if len(described) > 1 or node is not Nodetype.SEQUENCE or content[0][0] is not Nodetype.NAME:
        raise ValueError(f'message type {kind!r} is not installed: only sequences can be made')
    return str(name), str(content[0][1])


def _at(support: _Support, kind: Any) -> Any:
    return kind.from_address(support.data)


def _lent(support: str, kind: str) -> _Support:
    """Return the support of an installed type."""
    package = kind.split('/')[0]
    module = importlib.import_module(package)
    for prefix in Path(str(module.__file__)).parents:
        file = prefix / 'lib' / f'lib{package}__{support}.so'
        if file.is_file():
            library = ctypes.CDLL(str(file))
            symbol = f'{support}__get_message_type_support_handle__{kind}'.replace('/', '__')
            get = getattr(library, symbol)
            get.restype = ctypes.POINTER(_Support)
            _KEPT.append(library)
            found: _Support = get().contents
            return found
    raise ValueError(f'{package} has no {support}: no type can be made of {kind}')
