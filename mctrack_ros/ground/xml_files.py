"""Calibration XML: read without entities and checked against the schema, written as text."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from xml.sax.saxutils import quoteattr

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import ParseError
from defusedxml.ElementTree import fromstring as parse_guarded
from lxml import etree

from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.input_size import SETTINGS, check_size

SCHEMA = Path(__file__).with_name('calibration.xsd')
_NO_NUMBER = re.compile(
    r"Element '(\w+)', attribute '([xy][ri]?)': (?:\[facet '\w+'\] The value )?'(.*?)' is "
)
DECLARATION = '<?xml version="1.0" encoding="utf-8"?>'


def read_xml(path: str | Path, error: type[CalibrationError]) -> etree._Element:
    """
    Read an XML file that declares no entities; its elements know their lines.

    Parameters
    ----------
    path : str or Path
        The file.
    error : type
        What to raise, with the file and, where there is one, the line.

    """
    check_size(path, SETTINGS, error)
    try:
        content = Path(path).read_bytes()
        parse_guarded(content, forbid_dtd=True)
        parser = etree.XMLParser(
            resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True
        )
        return etree.fromstring(content, parser)
    except OSError as cause:
        raise error(f'{path}: {cause.strerror or cause}') from cause
    except DefusedXmlException as cause:
        raise error(
            f'{path}: not a readable XML file: document types and entities are refused'
        ) from cause
    except (ParseError, etree.XMLSyntaxError, ValueError) as cause:
        raise error(f'{path}: not a readable XML file: {cause}') from cause


def read_checked(path: str | Path, root: str, error: type[CalibrationError]) -> etree._Element:
    """
    Read an XML file and check it against the schema, ``calibration.xsd``.

    Parameters
    ----------
    path : str or Path
        The file.
    root : str
        Name of the root element: ``scene`` or ``workstation``.
    error : type
        What to raise, with file, line and reason.

    """
    element = read_xml(path, error)
    if element.tag != root:
        raise error(f'{path}:{element.sourceline}: the root is <{element.tag}>, expected <{root}>')
    schema = _schema()
    if not schema.validate(element):
        flaw = schema.error_log[0]
        raise error(f'{path}:{flaw.line}: {_explained(" ".join(flaw.message.split()))}')
    return element


def _explained(message: str) -> str:
    """Return what the schema has against a coordinate, so that a person knows what to mend."""
    found = _NO_NUMBER.match(message)
    if found is None:
        return message
    element, name, value = found.groups()
    return (
        f'<{element}> {name} is {value!r}, expected a number such as 12.5 (no unit, no comma, '
        'at most 1e9): measure or click it anew, or leave it out'
    )


@cache
def _schema() -> etree.XMLSchema:
    return etree.XMLSchema(etree.parse(str(SCHEMA)))


def tag(name: str, /, *, end: str = '/', **attributes: str | float) -> str:
    """Return an element's tag as it stands in a file; numbers in full precision."""
    values = ''.join(
        f' {key}={quoteattr(value if isinstance(value, str) else repr(value))}'
        for key, value in attributes.items()
    )
    return f'<{name}{values}{end}>'


def write_lines(path: str | Path, lines: list[str]) -> None:
    """Write the lines of an XML file below its declaration."""
    Path(path).write_text('\n'.join([DECLARATION, *lines]) + '\n', encoding='utf-8', newline='\n')
