"""A finished bag from one that was cut off."""

from __future__ import annotations

import shutil
import tempfile
import warnings
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from mctrack_ros.recording.bags.attached import attachments
from mctrack_ros.recording.bags.bag import BagReader
from mctrack_ros.recording.bags.sqlite_scan import journal_of, merged
from mctrack_ros.recording.bags.writer import BagWriter, check_place
from mctrack_ros.recording.errors import BagError, CutBagWarning
from mctrack_ros.recording.track_log.log import CHECKSUMS, SUMMARY, StoredLog


def repair_bag(path: str | Path, out: str | Path, *, overwrite: bool = False) -> tuple[int, float]:
    """
    Write all that can be read of a bag into a new one.

    Parameters
    ----------
    path : str or Path
        The bag; it stays as it is.
    out : str or Path
        The new one, MCAP.
    overwrite : bool
        Whether a bag already there is replaced.

    Returns
    -------
    messages : int
        How many were written.
    seconds : float
        From the first to the last, s.

    Warns
    -----
    CutBagWarning
        If something is missing or damaged; says what.

    Raises
    ------
    BagError
        If nothing can be read, or the new bag cannot be written.

    """
    path, out = Path(path), Path(out)
    if out.resolve() == path.resolve():
        raise BagError(f'{out} is the bag that is to be repaired: choose another name')
    check_place(out, overwrite)
    with tempfile.TemporaryDirectory(prefix='mctrack_') as folder:
        source = _without_journals(path, Path(folder))
        with BagReader(source) as reader:
            carried = attachments(source)
            times, damage = _copy(reader, carried, out, overwrite)
        if damage and not _packs_messages(source):
            with suppress(BagError), BagReader(source, scanned=True) as reader:
                times, damage = _copy(reader, carried, out, overwrite=True)
    if damage and not times:
        raise damage
    if damage:
        warnings.warn(f'{damage}: what comes after is lost', CutBagWarning, stacklevel=2)
    return len(times), (max(times) - min(times)) * 1e-9


def _copy(
    reader: BagReader, carried: Mapping[str, bytes], out: Path, overwrite: bool
) -> tuple[list[int], BagError | None]:
    """Write a bag into a new one, up to an error; return the messages' log times, ns."""
    times: list[int] = []
    try:
        made_by = StoredLog.of({SUMMARY: carried.get(SUMMARY, b'{}')}).made_by
    except ValueError:
        made_by = {}
    with BagWriter(out, overwrite=overwrite, made_by=made_by) as writer:
        for name, data in carried.items():
            if name != SUMMARY and not name.startswith(CHECKSUMS):
                writer.attach({name: data}, 'application/octet-stream')
        try:
            for item in reader.serialized():
                writer.write_copy(reader, *item)
                times.append(item[-1])
        except BagError as error:
            return times, error
    return times, None


def _packs_messages(path: Path) -> bool:
    """Tell whether each message is packed by itself: only the metadata say so."""
    metadata = path / 'metadata.yaml'
    return metadata.exists() and 'compression_mode: message' in metadata.read_text().lower()


def _without_journals(path: Path, folder: Path) -> Path:
    """Return the bag, or a copy of it in a folder whose databases are merged with journals."""
    files = sorted(path.glob('*.db3')) if path.is_dir() else [path]
    if not any(map(journal_of, files)):
        return path
    for file in files:
        if journal_of(file):
            merged(file, folder)
        else:
            shutil.copy(file, folder)
    return folder
