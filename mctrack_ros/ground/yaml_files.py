"""Calibration and site YAML: read without what unfolds into far more than the file holds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from mctrack_ros.input_size import SETTINGS, check_size

LARGEST = 100_000
"""Values that a file may hold, what its aliases repeat counted again and again."""


def read_yaml_file(path: str | Path, error: type[ValueError]) -> Any:
    """
    Return what a YAML file of one document holds; None if it is empty.

    Aliases are read, but neither a few lines of them that stand for a billion values nor one that
    stands within itself.

    Parameters
    ----------
    path : str or Path
        The file.
    error : type
        What to raise, with the file and the reason.

    """
    documents = read_yaml_documents(path, error)
    if len(documents) > 1:
        raise error(f'{path}: not a readable YAML file: it holds several documents, expected one')
    return documents[0] if documents else None


def read_yaml_documents(path: str | Path, error: type[ValueError]) -> list[Any]:
    """
    Return what each document of a YAML file holds; aliases as `read_yaml_file` reads them.

    Parameters
    ----------
    path : str or Path
        The file; OpenCV's first line, ``%YAML:1.0``, is passed over.
    error : type
        What to raise, with the file and the reason.

    """
    check_size(path, SETTINGS, error)
    try:
        text = Path(path).read_text(encoding='utf-8')
        return _documents(text.partition('\n')[2] if text.startswith('%YAML:') else text)
    except OSError as cause:
        raise error(f'{path}: {cause.strerror or cause}') from cause
    except RecursionError as cause:
        raise error(f'{path}: not a readable YAML file: nested too deeply') from cause
    except (yaml.YAMLError, ValueError) as cause:
        reason = ' '.join(str(cause).split())
        raise error(f'{path}: not a readable YAML file: {reason}') from cause


def _documents(text: str) -> list[Any]:
    loader = yaml.SafeLoader(text)
    documents = []
    try:
        while loader.check_node():
            node = loader.get_node()
            if _unfolded(node, {}) > LARGEST:
                raise yaml.YAMLError(
                    f'its aliases unfold into more than {LARGEST} values: write them out'
                )
            _check_single_keys(node)
            documents.append(loader.construct_document(node))
        return documents
    finally:
        loader.dispose()


def _check_single_keys(node: Any) -> None:
    """Refuse a mapping in which a key stands twice: one of its values would be lost."""
    if isinstance(node, yaml.MappingNode):
        seen = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode) and key.value in seen:
                line = key.start_mark.line + 1
                raise yaml.YAMLError(f'{key.value} stands twice in it, again in line {line}')
            seen.add(key.value if isinstance(key, yaml.ScalarNode) else id(key))
    if isinstance(node, yaml.CollectionNode):
        for each in node.value:
            for part in each if isinstance(each, tuple) else (each,):
                _check_single_keys(part)


def _unfolded(node: Any, known: dict[int, int]) -> int:
    """Return how many values a node holds, each alias counted as all that it stands for."""
    if isinstance(node, yaml.ScalarNode):
        return 1
    if id(node) not in known:
        known[id(node)] = LARGEST + 1  # until it is counted: an alias within itself
        pairs = isinstance(node, yaml.MappingNode)
        inner = [each for pair in node.value for each in pair] if pairs else node.value
        known[id(node)] = 1 + sum(_unfolded(each, known) for each in inner)
    return known[id(node)]
