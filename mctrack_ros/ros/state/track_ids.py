"""Ids of tracks that no run deals out again: a file says which may have been."""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path
from typing import IO

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion.management.initiation import MOST_STARTS

_BLOCK = 1000
"""Number of ids that are reserved at a time; unused ones are lost when the process is killed."""
_LAST_START = 2**31
"""A run that would begin above this begins at 1 again: each has half of all ids at least."""
_REASON = 'without it ids of tracks could be used twice'


class TrackIds:
    """
    Reserve ids in a file before they are used, so that even a killed process used no others.

    The file is replaced, never changed, and locked through one beside it.

    Parameters
    ----------
    path : Path or None
        The file, made if it is missing; None: every run begins at 1.

    Attributes
    ----------
    path : Path or None
        The file.
    first : int
        Id with which this run begins.
    began_again : bool
        Whether that is 1 because ids had come to half of what 32 bits hold.

    Raises
    ------
    ConfigError
        If the file cannot be read, written or locked.

    """

    def __init__(self, path: Path | None) -> None:
        self.path, self._next, self._reserved = path, 1, 0
        self._failure = ''
        self._lock: IO[str] | None = None
        self.first, self.began_again = 1, False
        if path is None:
            return
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._lock = _locked(path)
            kept = _read(path)
            self.began_again = kept > _LAST_START
            self.first = 1 if self.began_again else kept
            self.keep_ahead(self.first)
        except OSError as error:
            self._unlock()
            raise ConfigError(f'state_file {path}: {error.strerror}: {_REASON}') from error
        except ConfigError:
            self._unlock()
            raise

    def keep_ahead(self, next_id: int) -> None:
        """
        Reserve what the next tick may use.

        Raises
        ------
        OSError
            If the file cannot be written; it is tried again next time.

        """
        self._next = next_id
        if self.path is None or next_id + MOST_STARTS <= self._reserved:
            return
        try:
            _replace(self.path, next_id + _BLOCK)
        except OSError as error:
            self._failure = f'{self.path}: {error.strerror}'
            raise
        self._failure, self._reserved = '', next_id + _BLOCK

    def close(self, next_id: int) -> None:
        """Keep which ids were used in fact, and let others have the file."""
        try:
            if self.path is not None:
                _replace(self.path, next_id)
        finally:
            self._unlock()

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state; ids that are not reserved are an error."""
        values = {
            'next id': str(self._next),
            'reserved below': str(self._reserved),
            'file': str(self.path or ''),
        }
        message = 'ids are never used twice' if self.path else 'ids begin at 1 with each start'
        if self._failure:
            message = f'ids may be used again after a restart: {self._failure}'
        return DiagnosticStatus(
            level=DiagnosticStatus.ERROR if self._failure else DiagnosticStatus.OK,
            name=name,
            message=message,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )

    def _unlock(self) -> None:
        if self._lock is not None:
            self._lock.close()
            self._lock = None


def state_path(setting: str, domain: int, node: str) -> Path | None:
    """
    Return where a node keeps which ids it has used.

    Parameters
    ----------
    setting : str
        A path, ``auto`` for one of the node's own below ``ROS_HOME`` or ``~/.ros``, or nothing.
    domain : int
        Of ROS, in which the node is.
    node : str
        Its fully qualified name.

    Raises
    ------
    ConfigError
        If there is no home directory.

    """
    if not setting:
        return None
    try:
        if setting != 'auto':
            return Path(setting).expanduser().absolute()
        home = os.environ.get('ROS_HOME') or Path.home() / '.ros'
    except RuntimeError as error:
        raise ConfigError(f'state_file is {setting}, but there is no home: {error}') from error
    return Path(home, 'mctrack_ros', f'domain_{domain}', *node.strip('/').split('/')).with_suffix(
        '.json'
    )


def _locked(path: Path) -> IO[str]:
    """Lock a file for as long as the returned one is open."""
    lock = path.with_name(path.name + '.lock').open('a+', encoding='utf-8')
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        lock.seek(0)
        owner = lock.read().strip()
        lock.close()
        if not isinstance(error, BlockingIOError):
            raise
        raise ConfigError(
            f'state_file {path} is in use by another fusion node (process {owner}): end that one, '
            'or give this one another namespace, name or state_file'
        ) from error
    lock.truncate(0)
    lock.write(str(os.getpid()))
    lock.flush()
    return lock


def _read(path: Path) -> int:
    """Return the first id that was not used; 1 if there is no file."""
    try:
        kept = json.loads(path.read_text(encoding='utf-8'))['next_id']
    except FileNotFoundError:
        return 1
    except (ValueError, LookupError, TypeError):
        kept = None
    if not isinstance(kept, int) or kept < 1:
        raise ConfigError(f'state_file {path} holds no next_id: delete it to begin at 1 again')
    return kept


def _replace(path: Path, next_id: int) -> None:
    """Write a file so that, whatever happens, there is the old one or the new one."""
    fresh = path.with_name(path.name + '.new')
    with fresh.open('w', encoding='utf-8') as file:
        json.dump({'next_id': next_id}, file)
        file.flush()
        os.fsync(file.fileno())
    fresh.replace(path)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
