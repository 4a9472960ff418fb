"""What is attached to a bag: small files beside its messages."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Attachment
from mcap.stream_reader import StreamReader

PARAMETERS = 'mctrack/parameters.yaml'
"""Attachment: how all parts, or nodes, were set."""
_BROKEN = (McapError, OSError, EOFError, ValueError, StopIteration, struct.error)
"""What the reader raises where a file breaks off or is damaged."""


def attachments(path: str | Path) -> dict[str, bytes]:
    """
    Return the attachments of a bag by name; of one name, the last of the last file.

    A bag that breaks off is read as far as it goes. SQLite files hold none.

    Parameters
    ----------
    path : str or Path
        The bag, or one of its files.

    """
    path, found = Path(path), dict[str, bytes]()
    files = sorted(path.glob('*.mcap'), key=_place) if path.is_dir() else [path]
    for file in files:
        if file.suffix == '.mcap':
            found |= {each.name: each.data for each in _attached(file)}
    return found


def _place(file: Path) -> list[int]:
    """Return the number of a file among those of its bag."""
    return [int(number) for number in re.findall('[0-9]+', file.stem)[-1:]]


def _attached(file: Path) -> Iterator[Attachment]:
    """Yield a file's attachments: by its index, or record by record where it has none."""
    with file.open('rb') as stream:
        try:
            found = list(make_reader(stream).iter_attachments())
        except _BROKEN:
            found = []
            stream.seek(0)
            try:
                for record in StreamReader(stream, emit_chunks=True).records:
                    if isinstance(record, Attachment):
                        found.append(record)
            except _BROKEN:
                pass
    yield from found
