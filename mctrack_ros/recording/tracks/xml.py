"""Small XML files: metadata of sports formats."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import defusedxml.ElementTree
from defusedxml import DefusedXmlException

from mctrack_ros.input_size import SETTINGS, check_size
from mctrack_ros.recording.tables.columns import TableError


def add(parent: Element, tag: str, text: object = None, /, **attributes: object) -> Element:
    """Add an element with a text and attributes; return it."""
    made = SubElement(parent, tag, {key: str(value) for key, value in attributes.items()})
    made.text = None if text is None else str(text)
    return made


def add_texts(parent: Element, **texts: object) -> None:
    """Add an element with a text for each tag."""
    for tag, text in texts.items():
        add(parent, tag, text)


def write_xml(path: Path, root: Element) -> None:
    """Write a document."""
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding='utf-8', xml_declaration=True)


def read_xml(path: Path) -> Element:
    """Read a document; raises `TableError` if it is none."""
    check_size(path, SETTINGS, TableError)
    try:
        root = defusedxml.ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError, DefusedXmlException) as error:
        raise TableError(f'{path} cannot be read: {error}') from error
    assert root is not None
    return root


def metadata_file(path: Path, endings: tuple[str, ...] = ('.xml',)) -> Path:
    """Return the file of metadata beside a file: the first ending that is there, or the first."""
    named = [path.with_name(f'{path.stem}_metadata{ending}') for ending in endings]
    return next((each for each in named if each.is_file()), named[0])
