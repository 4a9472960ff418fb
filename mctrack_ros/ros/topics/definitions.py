"""How the message types of the ROS environment are defined: from their packages' own files."""

from __future__ import annotations

import importlib
import json
from collections.abc import Collection
from pathlib import Path

from mctrack_ros.recording.bags.definitions import TypeDefinition, known_definition

_LINE = '=' * 80


def definition_of(kind: str, announced: Collection[str]) -> TypeDefinition:
    """
    Return how a type is defined, as its publishers send it.

    Parameters
    ----------
    kind : str
        The type, as in ``std_msgs/msg/String``.
    announced : collection of str
        Hashes of it that publishers announce; empty: none is known.

    Raises
    ------
    ValueError
        If it is not described here, or they send another definition of it.

    """
    found = [each for each in (installed_definition(kind), known_definition(kind)) if each]
    for definition in found:
        if set(announced) <= {definition.type_hash}:
            return definition
    if found:
        raise ValueError(f'it is published by another definition of {kind} than is installed here')
    raise ValueError(f'the files that define {kind} are not installed')


def installed_definition(kind: str) -> TypeDefinition | None:
    """Return the definition that the package of a type brings; None: it brings none."""
    described = _file(kind, '.json')
    if described is None:
        return None
    content = json.loads(described.read_text(encoding='utf-8'))
    within = content['type_description_msg']['referenced_type_descriptions']
    kinds = [kind, *(each['type_name'] for each in within)]
    hashes = {each['type_name']: each['hash_string'] for each in content['type_hashes']}
    for ending in ('.msg', '.idl'):
        files = [_file(each, ending) for each in kinds]
        texts = [file.read_text(encoding='utf-8') for file in files if file]
        if len(texts) == len(kinds):
            return TypeDefinition(_joined(kinds, texts, ending), hashes[kind])
    return None


def _joined(kinds: list[str], texts: list[str], ending: str) -> str:
    """Return the definitions as rosbag2 puts them into a bag."""
    names = ['/'.join(kind.split('/')[::2]) for kind in kinds]
    if ending == '.idl':
        parts = [f'{_LINE}\nIDL: {kind}\n{text}' for kind, text in zip(kinds, texts)]
        return '\n'.join(parts)
    parts = [f'{_LINE}\nMSG: {name}\n{text}' for name, text in zip(names[1:], texts[1:])]
    return '\n'.join([texts[0], *parts])


def _file(kind: str, ending: str) -> Path | None:
    """Return the file of a type in its package's share folder."""
    package = kind.split('/')[0]
    try:
        module = importlib.import_module(package)
    except ImportError:
        return None
    for prefix in Path(str(module.__file__)).parents:
        file = prefix / 'share' / f'{kind}{ending}'
        if file.is_file():
            return file
    return None
