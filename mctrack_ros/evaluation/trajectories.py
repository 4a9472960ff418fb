"""Truth and tracks in the form that metrics take: who was where at which time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.interfaces import REPORTED, Tracks


@dataclass(frozen=True, eq=False, slots=True)
class Trajectories:
    """
    Rows of truth or of tracks, in any order; ground positions or image boxes.

    Arrays are converted and checked; one that is left out is empty.

    Attributes
    ----------
    frame : (n,) int64 array
        Number of the instant.
    id : (n,) int64 array
        Who; once a frame.
    position : (n, 2) float64 array
        On the ground, m.
    box : (n, 4) float64 array
        Left, top, width, height, px.
    ignore : (n,) bool array
        Truth that does not count: it is left out, and so is the track matched to it.

    Raises
    ------
    ValueError
        If shapes disagree, a value is not finite, or an id stands twice in a frame.

    """

    frame: NDArray[np.int64]
    id: NDArray[np.int64]
    position: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))
    box: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 4)))
    ignore: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, np.bool_))

    def __post_init__(self) -> None:
        """Convert, check and freeze the arrays."""
        count = len(np.asarray(self.frame))
        if not len(self.ignore):
            object.__setattr__(self, 'ignore', np.zeros(count, np.bool_))
        self._convert('frame', np.int64, (count,))
        self._convert('id', np.int64, (count,))
        self._convert('ignore', np.bool_, (count,))
        self._convert('position', np.float64, (count if len(self.position) else 0, 2))
        self._convert('box', np.float64, (count if len(self.box) else 0, 4))
        if count and not len(self.position) and not len(self.box):
            raise ValueError(f'{count} rows have neither a position nor a box')
        self._check_finite('position')
        self._check_finite('box')
        self._check_unique()

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.frame)

    @classmethod
    def from_tracks(
        cls, instants: Iterable[Tracks], period_ns: int, origin_ns: int = 0
    ) -> Trajectories:
        """
        Collect fused tracks, or truth in the same rows.

        Parameters
        ----------
        instants : iterable of Tracks
            One for each tick.
        period_ns : int
            Period of the ticks, ns; a row's frame is ``(stamp - origin) // period``.
        origin_ns : int
            Where frame 0 begins, ns.

        Returns
        -------
        Trajectories
            Ground positions of the confirmed, coasting and grouped tracks.

        """
        empty = Tracks.build(0)
        kept = [empty, *(rows.select(np.isin(rows.status, REPORTED)) for rows in instants)]
        frames = [np.full(len(rows), (rows.stamp_ns - origin_ns) // period_ns) for rows in kept]
        return cls(
            frame=np.concatenate(frames),
            id=np.concatenate([rows.track_id for rows in kept]).astype(np.int64),
            position=np.concatenate([rows.position[:, :2] for rows in kept]).astype(np.float64),
        )

    def select(self, mask: NDArray[np.bool_]) -> Self:
        """Return the rows that a (n,) mask picks."""
        return type(self)(
            self.frame[mask],
            self.id[mask],
            self.position[mask] if len(self.position) else self.position,
            self.box[mask] if len(self.box) else self.box,
            self.ignore[mask],
        )

    def at_frames(self, frames: ArrayLike) -> Self:
        """Return the rows of some frames: those that truth, sparser than the tracks, covers."""
        return self.select(np.isin(self.frame, np.asarray(frames)))

    def _convert(self, name: str, dtype: Any, shape: tuple[int, ...]) -> None:
        given = np.asarray(getattr(self, name))
        array = given.astype(dtype)
        if given.size and array.dtype.kind == 'i' and not np.array_equal(array, given):
            raise ValueError(f'{name} holds values that are not whole numbers')
        if array.shape != shape:
            raise ValueError(f'{name} has shape {array.shape}, expected {shape}')
        array.flags.writeable = False
        object.__setattr__(self, name, array)

    def _check_finite(self, name: str) -> None:
        bad = np.flatnonzero(~np.isfinite(getattr(self, name)).all(axis=1))
        if bad.size:
            row = bad[0]
            raise ValueError(
                f'the {name} of id {self.id[row]} in frame {self.frame[row]} is '
                f'{getattr(self, name)[row].tolist()}, expected finite numbers'
            )

    def _check_unique(self) -> None:
        order = np.lexsort((self.id, self.frame))
        frame, ids = self.frame[order], self.id[order]
        again = np.flatnonzero((np.diff(frame) == 0) & (np.diff(ids) == 0))
        if again.size:
            raise ValueError(f'id {ids[again[0]]} stands twice in frame {frame[again[0]]}')
