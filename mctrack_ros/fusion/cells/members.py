"""The tracks of all cells at one instant, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.cells.report import CellReport, usable
from mctrack_ros.interfaces import REPORTED, TEMPLATE_SIZE, TrackStatus
from mctrack_ros.tracking.kalman import predict

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

OLDEST_S = 1e9
"""No track is older, s."""
SEEN = (TrackStatus.CONFIRMED, TrackStatus.GROUPED)
"""What a cell sees now, alone or in a group; the rest it predicts."""


@dataclass(frozen=True, eq=False)
class CellTracks:
    """
    One row for each track that a cell stands for, sorted by cell, then the cell's id.

    Attributes
    ----------
    cell : (m,) int array
        Index in the site's order.
    name : (m,) int array
        What the cell calls it.
    stamp_ns : (m,) int array
        Of the state, ns.
    mean : (m, 4) array
        x, y, vx, vy; m and m/s.
    covariance : (m, 4, 4) array
        With what all tracks of a cell share.
    is_seen : (m,) bool array
        Whether a camera of the cell sees it.
    template : (m, 48) float32 array
        Colours; zero: not known.
    extent : (m, 2) float32 array
        Width and height, m; NaN: not known.
    class_id : (m,) uint8 array
    score : (m,) array
    group : (m,) int array
        Which group it is in, by the cell's own number; 0: none.
    first_ns : (m,) int array
        Stamp from which on the cell has it, ns.

    """

    cell: Indices
    name: Indices
    stamp_ns: NDArray[np.int64]
    mean: Floats
    covariance: Floats
    is_seen: Mask
    template: NDArray[np.float32]
    extent: NDArray[np.float32]
    class_id: NDArray[np.uint8]
    score: Floats
    group: Indices
    first_ns: NDArray[np.int64]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.cell)

    @cached_property
    def keys(self) -> list[tuple[int, int]]:
        """Return cell and the cell's id of each."""
        return list(zip(self.cell.tolist(), self.name.tolist()))

    @cached_property
    def bit(self) -> NDArray[np.uint32]:
        """Return the bit of each one's cell, (m,)."""
        return np.left_shift(np.uint32(1), self.cell.astype(np.uint32))

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the rows of several, one after the other."""
        return cls(
            *(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(cls))
        )

    def predicted(self, stamp_ns: int, density: float) -> Self:
        """Return them at a time, ns, under white acceleration of a density, m²/s³."""
        seconds = (stamp_ns - self.stamp_ns) * 1e-9
        mean, covariance = predict(self.mean, self.covariance, seconds, density)
        stamps = np.full(len(self), stamp_ns, np.int64)
        return replace(self, stamp_ns=stamps, mean=mean, covariance=covariance)


def cell_tracks_of(cell: int, report: CellReport, sigma: float) -> CellTracks:
    """
    Return what a cell stands for.

    Parameters
    ----------
    cell : int
        Its index.
    report : CellReport
        What it says.
    sigma : float
        Error of its places that all its tracks share, m.

    """
    tracks = report.tracks.select(usable(report.tracks) & np.isin(report.tracks.status, REPORTED))
    tracks = tracks.select(np.argsort(tracks.track_id))
    count = len(tracks)
    state = np.column_stack([tracks.position[:, :2], tracks.velocity]).astype(np.float64)
    spread = tracks.covariance.astype(np.float64)
    spread = (spread + spread.swapaxes(1, 2)) / 2
    shared = np.array([sigma, sigma, 0.0, 0.0]) ** 2
    template = np.zeros((count, TEMPLATE_SIZE), np.float32)
    place = {name: row for row, name in enumerate(report.feedback.track_id.tolist())}
    rows = np.array([place.get(name, -1) for name in tracks.track_id.tolist()], np.intp)
    template[rows >= 0] = report.feedback.template[rows[rows >= 0]]
    template[~np.isfinite(template).all(axis=1)] = 0.0
    return CellTracks(
        np.full(count, cell, np.intp),
        tracks.track_id.astype(np.intp),
        np.full(count, report.stamp_ns, np.int64),
        state,
        spread + np.diag(shared),
        np.isin(tracks.status, SEEN),
        template,
        tracks.extent,
        tracks.class_id,
        tracks.score.astype(np.float64),
        tracks.group.astype(np.intp),
        report.stamp_ns
        - (1e9 * np.clip(np.nan_to_num(tracks.age), 0.0, OLDEST_S)).astype(np.int64),
    )


NO_CELL_TRACKS = CellTracks(
    np.zeros(0, np.intp),
    np.zeros(0, np.intp),
    np.zeros(0, np.int64),
    np.zeros((0, 4)),
    np.zeros((0, 4, 4)),
    np.zeros(0, bool),
    np.zeros((0, TEMPLATE_SIZE), np.float32),
    np.zeros((0, 2), np.float32),
    np.zeros(0, np.uint8),
    np.zeros(0),
    np.zeros(0, np.intp),
    np.zeros(0, np.int64),
)
