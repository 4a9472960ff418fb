"""Shared memory that killed processes left behind."""

from __future__ import annotations

import fcntl
import re
from pathlib import Path

_SHARED_MEMORY = Path('/dev/shm')  # noqa: S108  not ours to name
_LOCK = re.compile(r'fastrtps_[0-9a-f]{16}_el')


def remove_leftovers(directory: Path = _SHARED_MEMORY) -> int:
    """
    Remove the segments of Fast DDS whose process is dead, as ``fastdds shm clean`` does.

    A process that lives holds a lock on the file beside its segment.

    Parameters
    ----------
    directory : Path
        Where the operating system keeps shared memory.

    Returns
    -------
    int
        How many segments were removed.

    """
    locks = [path for path in directory.glob('fastrtps_*_el') if _LOCK.fullmatch(path.name)]
    return sum(_removed(path) for path in locks)


def _removed(lock: Path) -> bool:
    """Remove one segment and its lock, unless it is in use or another's."""
    try:
        with lock.open('rb') as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            lock.with_name(lock.name.removesuffix('_el')).unlink(missing_ok=True)
            lock.unlink(missing_ok=True)
    except OSError:
        return False
    return True
