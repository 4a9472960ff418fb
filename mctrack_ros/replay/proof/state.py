"""
The whole state of a fusion tracker as bytes, and back: a replay can go on from the middle.

A tracker's state is what the attributes of its objects hold, and of the objects in them. Not part
of it are parameters and what is computed from calibrations: a tracker opened in the same way has
them already. Bytes hold arrays (npz, without pickle) and plain values (JSON); reading them makes
no objects but those of this package's classes.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable
from importlib import import_module
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import attributes_of
from mctrack_ros.fusion import FusionConfig
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.trackers import FusionTracker

FORMAT = 1
"""Counts up when older states can no longer be read."""

_PLAIN = (bool, int, float, str, type(None))
_LISTS: dict[str, Callable[[Any], Any]] = {
    'list': list,
    'tuple': tuple,
    'set': set,
    'frozenset': frozenset,
}
_OWN = 'mctrack_ros.'
_GIVEN = ('Scene', 'VehicleScene')
"""Classes of what is computed from calibrations."""


class StateError(ValueError):
    """A state that does not fit the tracker, or cannot be read."""


def dump_state(tracker: object, said: dict[str, Any]) -> bytes:
    """
    Return the state of a fusion tracker.

    Parameters
    ----------
    tracker : object
        As `open_fusion` returns it.
    said : dict
        Plain values that are kept beside it, for example the stamp of the last tick.

    Raises
    ------
    StateError
        If it holds something that has no place in a state.

    """
    return take_state(tracker).packed(said)


class TakenState(NamedTuple):
    """
    The state of a tracker at one time; the tracker may go on.

    Attributes
    ----------
    content : object
        Plain values.
    arrays : list of array
        Copies of the arrays in it.

    """

    content: Any
    arrays: list[NDArray[Any]]

    def packed(self, said: dict[str, Any]) -> bytes:
        """Return it as bytes; that takes some ten milliseconds, and may be done in a thread."""
        content = {'format': FORMAT, 'said': said, 'tracker': self.content}
        arrays: dict[str, Any] = {str(number): each for number, each in enumerate(self.arrays)}
        text = np.frombuffer(json.dumps(content).encode(), np.uint8)
        out = BytesIO()
        np.savez_compressed(out, content=text, **arrays)
        return out.getvalue()


def take_state(tracker: object) -> TakenState:
    """Copy the state of a fusion tracker, in about a millisecond; see `dump_state`."""
    dump = _Dump()
    content = dump.value(tracker, 'tracker')
    return TakenState(content, [array.copy() for array in dump.arrays])


def stated(data: bytes) -> dict[str, Any]:
    """Return the plain values that are kept beside a state."""
    said: dict[str, Any] = _read(data)[0]['said']
    return said


def restore_state(tracker: object, data: bytes) -> None:
    """
    Give a tracker, newly opened with the same parameters, the state of another.

    Raises
    ------
    StateError
        If the state is of another kind of tracker or of another version.

    """
    content, arrays = _read(data)
    restore = _Restore(arrays)
    if restore.value(content['tracker'], tracker) is not tracker:
        raise StateError(f'the state is not one of {type(tracker).__name__}')


def _read(data: bytes) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    try:
        with np.load(BytesIO(data)) as stored:
            content = json.loads(stored['content'].tobytes())
            arrays = [stored[str(number)] for number in range(len(stored.files) - 1)]
    except (ValueError, KeyError, OSError) as error:
        raise StateError(f'this is no state of a tracker: {error}') from error
    if content['format'] != FORMAT:
        raise StateError(f'the state has the format {content["format"]}, expected {FORMAT}')
    return content, arrays


def go_on_with(tracker: FusionTracker, data: bytes, first_id: int) -> None:
    """Give a tracker, newly opened, a state; its further tracks get ids from one on at least."""
    restore_state(tracker, data)
    tracker.next_id = max(tracker.next_id, first_id)


class _Dump:
    """Objects to plain values; arrays and objects that occur again are named by number."""

    def __init__(self) -> None:
        self.arrays: list[NDArray[Any]] = []
        self._seen: dict[int, int] = {}
        self._kept: list[object] = []  # else another object may get the number of one that is gone

    def value(self, value: Any, where: str) -> Any:
        if type(value) in _PLAIN:
            return value
        if isinstance(value, np.generic):
            return {'scalar': self._array(np.asarray(value))}
        if id(value) in self._seen:
            return {'again': self._seen[id(value)]}
        if isinstance(value, np.ndarray):
            return self._noted(value) | {
                'array': self._array(value),
                'is_frozen': not value.flags.writeable,
            }
        if isinstance(value, TrackTable):
            return self._noted(value) | {'table': self._array(value.records)}
        if type(value).__name__ in _LISTS:
            parts = [self.value(each, where) for each in value]
            return {type(value).__name__: parts}
        if isinstance(value, deque):
            return {'deque': [self.value(each, where) for each in value], 'most': value.maxlen}
        if isinstance(value, dict):
            pairs = [[self.value(k, where), self.value(v, where)] for k, v in value.items()]
            return {'dict': pairs}
        if not type(value).__module__.startswith(_OWN):
            raise StateError(f'{where} is a {type(value).__name__}, which has no place in a state')
        return self._object(value, where)

    def _object(self, value: Any, where: str) -> Any:
        said = self._noted(value) | {'class': f'{type(value).__module__}:{type(value).__name__}'}
        if isinstance(value, tuple):
            return said | {'items': [self.value(each, where) for each in value]}
        said['fields'] = {
            name: self.value(each, f'{where}.{name}')
            for name, each in attributes_of(value)
            if not _is_given(each)
        }
        return said

    def _noted(self, value: object) -> dict[str, Any]:
        """Give an object a number."""
        self._seen[id(value)] = number = len(self._seen)
        self._kept.append(value)
        return {'number': number}

    def _array(self, array: NDArray[Any]) -> int:
        self.arrays.append(array)
        return len(self.arrays) - 1


class _Restore:
    """Plain values to objects; what is there already and can change is changed in place."""

    def __init__(self, arrays: list[NDArray[Any]]) -> None:
        self._arrays = arrays
        self._made: dict[int, Any] = {}

    def value(self, said: Any, current: Any = None) -> Any:
        if not isinstance(said, dict):
            return said
        if 'again' in said:
            return self._made[said['again']]
        if 'class' in said:
            return self._object(said, current)
        if 'table' in said:
            records = self._arrays[said['table']]
            made: Any = TrackTable(records.view(f'V{records.itemsize}'), records.dtype)
            return self._keep(said, made)
        if 'array' in said:
            array = self._arrays[said['array']]
            array.setflags(write=not said['is_frozen'])
            return self._keep(said, array)
        if 'scalar' in said:
            return self._arrays[said['scalar']][()]
        if 'deque' in said:
            return deque((self.value(each) for each in said['deque']), said['most'])
        if 'dict' in said:
            return {self.value(key): self.value(value) for key, value in said['dict']}
        ((name, parts),) = said.items()
        return _LISTS[name](self.value(each) for each in parts)

    def _object(self, said: dict[str, Any], current: Any) -> Any:
        module, _, name = said['class'].partition(':')
        if not module.startswith(_OWN):
            raise StateError(f'{module} is not of this package')
        try:
            kind = getattr(import_module(module), name)
        except (ImportError, AttributeError) as error:
            raise StateError(f'there is no {module}.{name} any more') from error
        if 'items' in said:
            return self._keep(said, kind(*(self.value(each) for each in said['items'])))
        is_there = type(current) is kind and not _is_frozen(current)
        made = self._keep(said, current if is_there else object.__new__(kind))
        for field, value in said['fields'].items():
            object.__setattr__(made, field, self.value(value, getattr(made, field, None)))
        return made

    def _keep(self, said: dict[str, Any], made: Any) -> Any:
        self._made[said['number']] = made
        return made


def _is_given(value: object) -> bool:
    """Tell whether a newly opened tracker has a value already: parameters, places, functions."""
    kind = type(value)
    if isinstance(value, FusionConfig) or kind.__module__.endswith('.config'):
        return True
    return kind.__name__ in _GIVEN or (callable(value) and not kind.__module__.startswith(_OWN))


def _is_frozen(value: object) -> bool:
    parameters = getattr(type(value), '__dataclass_params__', None)
    return bool(parameters and parameters.frozen)
