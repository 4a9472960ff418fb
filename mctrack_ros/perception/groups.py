"""Which local tracks are one group, and when groups form and part (Definition 6, E5, E3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mctrack_ros.config import parameter

Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]


@dataclass(frozen=True)
class GroupConfig:
    """Parameters of `Groups`."""

    contact_share: float = parameter(
        0.5,
        "difference below which foreground joins nobody, as a share of its blob's mean",
        minimum=0.0,
        maximum=1.0,
    )
    part_s: float = parameter(
        0.4, 'time for which tracks must be apart to have parted [s]', minimum=0.0
    )


@dataclass(frozen=True, slots=True)
class Change:
    """
    A part that joined a group or left it.

    Attributes
    ----------
    merged : bool
        Joined (E5); else left (E3).
    part : tuple of int
        Local ids of the part, ascending.
    rest : tuple of int
        Local ids of the others that are, or were, in the group.

    """

    merged: bool
    part: tuple[int, ...]
    rest: tuple[int, ...]


class Groups:
    """
    Tracks in one part of the foreground touch; those that do, or did a moment ago, are a group.

    A group is what is connected by touching (groups of groups are groups), so its members part
    only when none of them has touched any of the others for some time. A track that is not seen
    stays as it was. Every event tells of one part; the largest part stays the group.

    Parameters
    ----------
    config : GroupConfig
        Parameters.

    """

    def __init__(self, config: GroupConfig) -> None:
        self._hold_ns = round(config.part_s * 1e9)
        self.restart()

    def restart(self) -> None:
        """Forget all groups."""
        self._id: Ints = np.zeros(0, np.int64)
        self._group: Ints = np.zeros(0, np.int64)
        self._touched_ns = np.full((0, 0), -self._hold_ns - 1, np.int64)
        self._last_ns = 0

    def step(self, local_id: Ints, part: Ints, stamp_ns: int) -> list[Change]:
        """
        Tell what changed.

        Parameters
        ----------
        local_id : (n,) int64 array
            Tracks that are believed, ascending.
        part : (n,) int64 array
            The part of the foreground each is in (see `contacts`); -1: not seen.
        stamp_ns : int
            Time of the picture, ns.

        """
        was = np.full(len(local_id), -1, np.int64)
        known = np.isin(local_id, self._id)
        place = np.searchsorted(self._id, local_id[known])
        was[known] = self._group[place]
        touched = np.full((len(local_id), len(local_id)), -self._hold_ns - 1, np.int64)
        touched[np.ix_(known, known)] = self._touched_ns[np.ix_(place, place)]
        seen = part >= 0
        together = (part[:, None] == part[None]) & seen[:, None] & seen[None]
        touched[together] = stamp_ns
        touched[~(seen[:, None] & seen[None])] += stamp_ns - self._last_ns
        joined = stamp_ns - touched < max(self._hold_ns, 1)
        np.fill_diagonal(joined, True)
        group = connected_components(coo_array(joined), directed=False)[1].astype(np.int64)
        self._id, self._group, self._touched_ns = local_id, group, touched
        self._last_ns = stamp_ns
        alone = was < 0  # new tracks were each on their own
        was[alone] = len(local_id) + was.max(initial=0) + 1 + np.arange(alone.sum())
        merged = [Change(True, *pair) for pair in _parts(local_id, group, was)]
        parted = _parts(local_id[known], was[known], group[known])
        return merged + [Change(False, *pair) for pair in parted]


def _parts(
    local_id: Ints, whole: Ints, part: Ints
) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Return every part of a whole but the largest, with the rest of the whole."""
    found = []
    for number in np.flatnonzero(np.bincount(whole) > 1).tolist() if len(whole) else []:
        inside = whole == number
        labels, counts = np.unique(part[inside], return_counts=True)
        for label in labels[np.argsort(-counts, kind='stable')][1:].tolist():
            leaving = inside & (part == label)
            rest = local_id[inside & ~leaving]
            found.append((tuple(local_id[leaving].tolist()), tuple(rest.tolist())))
    return found
