"""Where two track logs differ: first, and most."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import fields_of_cloud, stamp_ns_of

Fields = dict[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Difference:
    """
    A value that differs.

    Attributes
    ----------
    tick : int
        Number of the tick, from 0.
    stamp_ns : int
        Its stamp, ns.
    field : str
        The field; ``stamp`` or ``rows`` if these differ.
    row : int
        Of the first point that differs; -1: none in particular.
    track_id : int
        Its id; 0: none.
    there, here : str
        What the bag holds, and what the replay gives.
    size : float
        Largest absolute difference of that value; NaN: it is no number.

    """

    tick: int
    stamp_ns: int
    field: str
    row: int
    track_id: int
    there: str
    here: str
    size: float


def first_difference(tick: int, there: Any, here: Any) -> Difference | None:
    """
    Return the first field, and in it the first row, in which two clouds of tracks differ.

    Parameters
    ----------
    tick : int
        Its number.
    there, here : object
        ``PointCloud2`` of the bag and of the replay.

    """
    stamp_ns = stamp_ns_of(here)
    if stamp_ns_of(there) != stamp_ns:
        texts = str(stamp_ns_of(there)), str(stamp_ns)
        return Difference(tick, stamp_ns, 'stamp', -1, 0, *texts, np.nan)
    recorded, replayed = fields_of_cloud(there), fields_of_cloud(here)
    counts = _count(recorded), _count(replayed)
    if counts[0] != counts[1] or recorded.keys() != replayed.keys():
        return Difference(tick, stamp_ns, 'rows', -1, 0, str(counts[0]), str(counts[1]), np.nan)
    for name, values in replayed.items():
        rows = np.flatnonzero(_differ(recorded[name], values))
        if len(rows):
            row = int(rows[0])
            pair = recorded[name][row], values[row]
            texts = str(pair[0].tolist()), str(pair[1].tolist())
            track_id = int(replayed['track_id'][row])
            return Difference(tick, stamp_ns, name, row, track_id, *texts, _size(*pair))
    return None


def largest_difference(tick: int, there: Any, here: Any) -> Difference | None:
    """Return where two clouds of tracks differ most, in a field of floats; rows go by their id."""
    recorded, replayed = fields_of_cloud(there), fields_of_cloud(here)
    _, old, new = np.intersect1d(
        recorded['track_id'], replayed['track_id'], assume_unique=True, return_indices=True
    )
    worst: Difference | None = None
    for name, values in replayed.items():
        if values.dtype.kind != 'f' or name not in recorded:
            continue
        for one, other in zip(old.tolist(), new.tolist()):
            pair = recorded[name][one], values[other]
            size = _size(*pair)
            if size > (worst.size if worst else 0.0):
                texts = str(pair[0].tolist()), str(pair[1].tolist())
                track_id = int(replayed['track_id'][other])
                stamp_ns = stamp_ns_of(here)
                worst = Difference(tick, stamp_ns, name, other, track_id, *texts, size)
    return worst


def _count(fields: Fields) -> int:
    return len(next(iter(fields.values()), ()))


def _differ(there: NDArray[Any], here: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which rows differ in a bit."""
    pair = [np.ascontiguousarray(each).view(np.uint8) for each in (there, here)]
    rows = [each.reshape(len(here), -1) for each in pair]
    return np.asarray((rows[0] != rows[1]).any(axis=1))


def _size(there: Any, here: Any) -> float:
    """Return the largest absolute difference of two values; 0 where both are not known."""
    gap = np.abs(np.asarray(there, np.float64) - np.asarray(here, np.float64))
    return float(np.nan_to_num(gap, nan=0.0).max(initial=0.0))
