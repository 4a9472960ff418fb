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
        self._touched_ns: Ints = np.zeros((0, 0), np.int64)
        self._joined: Booleans = np.zeros((0, 0), np.bool_)
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
        same = np.array_equal(local_id, self._id)
        known = np.ones(len(local_id), np.bool_) if same else self._follow(local_id)
        joined = self._touch(part, stamp_ns)
        if same and np.array_equal(joined, self._joined):
            return []
        was, self._joined = self._group, joined
        labels = connected_components(coo_array(joined), directed=False)[1]
        self._group = labels.astype(np.int64)
        merged = _parts(local_id, self._group, was)
        parted = _parts(local_id[known], was[known], self._group[known])
        return [Change(True, *pair) for pair in merged] + [Change(False, *pair) for pair in parted]

    def _follow(self, local_id: Ints) -> Booleans:
        """Carry over what is known of tracks that live on; tell which. New ones are alone."""
        known = np.isin(local_id, self._id)
        place = np.searchsorted(self._id, local_id[known])
        group = np.arange(len(local_id)) + self._group.max(initial=0) + 1
        group[known] = self._group[place]
        touched = np.full((len(local_id), len(local_id)), -self._hold_ns - 1, np.int64)
        touched[np.ix_(known, known)] = self._touched_ns[np.ix_(place, place)]
        self._id, self._group, self._touched_ns = local_id, group, touched
        return np.asarray(known, np.bool_)

    def _touch(self, part: Ints, stamp_ns: int) -> Booleans:
        """Note who touches; return who touches or did a moment ago."""
        unseen = part < 0
        self._touched_ns[(part[:, None] == part) & ~unseen] = stamp_ns
        if unseen.any():
            self._touched_ns[unseen[:, None] | unseen] += stamp_ns - self._last_ns
        self._last_ns = stamp_ns
        joined = np.asarray(stamp_ns - self._touched_ns < max(self._hold_ns, 1))
        np.fill_diagonal(joined, True)
        return joined


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
