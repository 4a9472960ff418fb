"""The fused tracks in parallel arrays that grow and shrink together."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces import TEMPLATE_SIZE

NEVER_NS = -(2**62)


@dataclass
class TrackTable:
    """
    All tracks at one instant, sorted by id.

    Attributes
    ----------
    track_id : (n,) uint32 array
    mean : (n, 4) array
        x, y, vx, vy; m and m/s.
    covariance : (n, 4, 4) array
    first_ns : (n,) int64 array
        Stamp of the first detection.
    seen_ns : (n,) int64 array
        Stamp of the last detection of its own.
    kept_ns : (n,) int64 array
        Stamp of the last detection of its own or of a group that it is in.
    seen_by_ns : (n, cameras) int64 array
        Stamp of the last detection of its own, by camera.
    local_id : (n, cameras) uint32 array
        What each camera called it then; 0: nothing.
    evidence : (n,) array
        Log-odds of being a target.
    confirmed : (n,) bool array
    template : (n, 48) float32 array
        Appearance; zero: none yet.
    class_id, kit : (n,) uint8 array
    hidden_ns : (n, cameras) int64 array
        Stamp of the last group in which each camera saw it.
    group : (n,) uint32 array
        Smallest id of the group that it is in; 0: none.
    group_ns : (n,) int64 array
        Stamp of the last detection of that group.
    cameras : (n,) uint32 array
        Bits of the cameras that saw it this tick.
    origin : (n,) uint32 array
        Of which track it was part before it began; 0: of none.
    previous_id : (n,) uint32 array
        What it was called before this tick, where that changed; else 0.
    look : (n, 48) array
        Sum of the roots of its templates since it was last near another, weighted by time.
    look_s, judge_s : (n,) array
        For how long, in all cameras, that is; how long it must be to be judged, s.
    in_contact : (n,) bool array
        Whether it is near another.

    """

    track_id: NDArray[np.uint32]
    mean: NDArray[np.float64]
    covariance: NDArray[np.float64]
    first_ns: NDArray[np.int64]
    seen_ns: NDArray[np.int64]
    kept_ns: NDArray[np.int64]
    seen_by_ns: NDArray[np.int64]
    local_id: NDArray[np.uint32]
    evidence: NDArray[np.float64]
    confirmed: NDArray[np.bool_]
    template: NDArray[np.float32]
    class_id: NDArray[np.uint8]
    kit: NDArray[np.uint8]
    hidden_ns: NDArray[np.int64]
    group: NDArray[np.uint32]
    group_ns: NDArray[np.int64]
    cameras: NDArray[np.uint32]
    origin: NDArray[np.uint32]
    previous_id: NDArray[np.uint32]
    look: NDArray[np.float64]
    look_s: NDArray[np.float64]
    judge_s: NDArray[np.float64]
    in_contact: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of tracks."""
        return len(self.track_id)

    @classmethod
    def blank(cls, count: int, cameras: int) -> Self:
        """Return that many tracks of which nothing is known."""
        return cls(
            track_id=np.zeros(count, np.uint32),
            mean=np.zeros((count, 4)),
            covariance=np.zeros((count, 4, 4)),
            first_ns=np.zeros(count, np.int64),
            seen_ns=np.zeros(count, np.int64),
            kept_ns=np.zeros(count, np.int64),
            seen_by_ns=np.full((count, cameras), NEVER_NS, np.int64),
            local_id=np.zeros((count, cameras), np.uint32),
            evidence=np.zeros(count),
            confirmed=np.zeros(count, bool),
            template=np.zeros((count, TEMPLATE_SIZE), np.float32),
            class_id=np.zeros(count, np.uint8),
            kit=np.zeros(count, np.uint8),
            hidden_ns=np.full((count, cameras), NEVER_NS, np.int64),
            group=np.zeros(count, np.uint32),
            group_ns=np.full(count, NEVER_NS, np.int64),
            cameras=np.zeros(count, np.uint32),
            origin=np.zeros(count, np.uint32),
            previous_id=np.zeros(count, np.uint32),
            look=np.zeros((count, TEMPLATE_SIZE)),
            look_s=np.zeros(count),
            judge_s=np.zeros(count),
            in_contact=np.zeros(count, bool),
        )

    def select(self, index: NDArray[np.bool_] | NDArray[np.integer]) -> Self:
        """Return a copy of the tracks that a mask or an index array picks."""
        return type(self)(**{name: array[index] for name, array in self._arrays().items()})

    def extended(self, other: Self) -> Self:
        """Return these tracks and then the other ones, or themselves if there are none."""
        if not len(other):
            return self
        added = other._arrays()
        return type(self)(
            **{
                name: np.concatenate([array, added[name]])
                for name, array in self._arrays().items()
            }
        )

    def rename(self, changes: dict[int, int]) -> NDArray[np.intp]:
        """Change ids, old to new, all at once; return the order by which they ascend."""
        changed = np.isin(self.track_id, list(changes))
        self.previous_id[changed] = self.track_id[changed]
        for ids in (self.track_id, self.group, self.origin):
            ids[:] = [changes.get(one, one) for one in ids.tolist()]
        return np.argsort(self.track_id)

    def _arrays(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
