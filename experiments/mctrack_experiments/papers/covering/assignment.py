"""The greedy exchange beside the best assignment of every sensor: cost, time, share of a tick."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_experiments.papers.covering.code_cost import LARGEST_CODE_COST, METHOD
from mctrack_ros.fusion.association.config import CoveringConfig
from mctrack_ros.fusion.association.solvers import ASSOCIATORS, Associator, Pairs
from mctrack_ros.fusion.association.solvers.covering_graph import CoveringGraph, exchange, flags
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.fusion.update.update import ASSOCIATIONS

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

UNASSIGNED = {'covering_text': 13.8, 'covering_code': LARGEST_CODE_COST}
"""What a track without a detection costs: the gate, and the code's largest cost."""
REPEATS = 5
"""Time is the least of so many turns."""


class BestPerSensor:
    """
    The covering graph whose sensors assign for the least sum of costs instead of greedily.

    Parameters
    ----------
    unassigned : float
        What a track without a detection costs.

    """

    def __init__(self, unassigned: float = UNASSIGNED['covering_text']) -> None:
        self._unassigned = unassigned

    def probabilities(self, pairs: Pairs) -> Floats:
        """Return ones and zeros, (k,), one at most for a track and for a detection."""
        chosen = np.zeros(len(pairs.slot))
        for rows in flagged(pairs):
            chosen[rows[best(pairs, rows, self._unassigned)]] = 1.0
        return chosen


@dataclass(frozen=True, slots=True)
class Assignments:
    """
    What both gave on the same pairs.

    Attributes
    ----------
    ticks, images : int
        How many there were; images with two or more tracks to assign.
    contested : int
        Images where not every track got its first choice.
    worse : int
        Images where the exchange costs more than need be.
    cost_ratio, largest_ratio : float
        Greedy over best: of the sums, and of one image at most.
    proposals, bound : int
        The exchange's proposals, and tracks times detections, summed.
    late : int
        Images that took more rounds than they had tracks.
    greedy_us, best_us : float
        Processor time a tick, flags included.

    """

    ticks: int
    images: int
    contested: int
    worse: int
    cost_ratio: float
    largest_ratio: float
    proposals: int
    bound: int
    late: int
    greedy_us: float
    best_us: float


@contextmanager
def recorded() -> Iterator[list[Pairs]]:
    """Keep the pairs that a covering graph is given meanwhile."""
    kept: list[Pairs] = []

    class Recorder(CoveringGraph):
        def probabilities(self, pairs: Pairs) -> Floats:
            kept.append(pairs)
            return super().probabilities(pairs)

    with replaced(Recorder):
        yield kept


@dataclass(slots=True)
class Stopwatch:
    """Processor time, s, added up."""

    spent_s: float = 0.0

    @contextmanager
    def on(self) -> Iterator[None]:
        """Count what is done inside."""
        began = time.process_time()
        yield
        self.spent_s += time.process_time() - began


@contextmanager
def timed_association() -> Iterator[Stopwatch]:
    """Time the covering graph's whole association meanwhile: gate, costs, C, F, exchange."""
    usual, clock = ASSOCIATIONS[METHOD], Stopwatch()

    class Timed(usual):  # type: ignore[misc, valid-type]
        def __init__(self, table: TrackTable, batch: Batch, config: CoveringConfig) -> None:
            with clock.on():
                super().__init__(table, batch, config)

        def pairs(self) -> tuple[Indices, Indices]:
            with clock.on():
                rows, columns = super().pairs()
            return rows, columns

    ASSOCIATIONS[METHOD] = Timed
    try:
        yield clock
    finally:
        ASSOCIATIONS[METHOD] = usual


@contextmanager
def replaced(associator: type[Associator]) -> Iterator[None]:
    """Let another associator stand for the covering graph meanwhile."""
    usual = ASSOCIATORS[METHOD]
    ASSOCIATORS[METHOD] = associator
    try:
        yield
    finally:
        ASSOCIATORS[METHOD] = usual


def flagged(pairs: Pairs) -> list[Indices]:
    """Return the pairs (n,) of every sensor's own tracks, sensor by sensor."""
    rows = np.flatnonzero(flags(pairs))
    starts = np.flatnonzero(np.diff(pairs.image[rows])) + 1
    return np.split(rows, starts) if len(rows) else []


def best(pairs: Pairs, rows: Indices, unassigned: float) -> Indices:
    """Return which of one image's pairs, (n,) rows, cost least together."""
    tracks, track = np.unique(pairs.slot[rows], return_inverse=True)
    detections, detection = np.unique(pairs.detection[rows], return_inverse=True)
    matrix = np.full((len(tracks), len(detections) + len(tracks)), unassigned)
    matrix[:, : len(detections)] = 2 * unassigned + 1e3
    number = np.zeros(matrix.shape, np.int64)
    matrix[track, detection], number[track, detection] = cost_of(pairs, rows), np.arange(len(rows))
    taken, column = linear_sum_assignment(matrix)
    own = column < len(detections)
    return np.asarray(number[taken[own], column[own]])


def cost_of(pairs: Pairs, rows: Indices) -> Floats:
    """Return what pairs cost, (n,)."""
    return np.asarray(-2 * np.log(pairs.likelihood[rows]))


def compared(kept: Sequence[Pairs], name: str) -> Assignments:
    """Return what both ways to assign give, and take, for one of the costs."""
    unassigned = UNASSIGNED[name]
    images = contested = worse = proposals = bound = late = 0
    costs, largest = np.zeros(2), 1.0
    for pairs in kept:
        for rows in flagged(pairs):
            slot, detection = pairs.slot[rows], pairs.detection[rows]
            tracks = len(np.unique(slot))
            if tracks < 2:
                continue
            greedy, rounds, asked = exchange(slot, detection, pairs.likelihood[rows])
            own = np.array(
                [
                    cost_of(pairs, rows[chosen]).sum() + unassigned * (tracks - len(rows[chosen]))
                    for chosen in (greedy, best(pairs, rows, unassigned))
                ]
            )
            costs += own
            largest = max(largest, own[0] / own[1] if own[1] else 1.0)
            images, proposals = images + 1, proposals + asked
            bound += tracks * len(np.unique(detection))
            contested += bool(asked > tracks or greedy.sum() < tracks)
            worse, late = worse + bool(own[0] > own[1] * (1 + 1e-9)), late + (rounds > tracks)
    times = [_time_us(each, kept) for each in (CoveringGraph(), BestPerSensor(unassigned))]
    ratio = float(costs[0] / costs[1]) if images else 1.0
    return Assignments(
        len(kept),
        images,
        contested,
        worse,
        ratio,
        float(largest),
        proposals,
        bound,
        late,
        *times,
    )


def _time_us(associator: Associator, kept: Sequence[Pairs]) -> float:
    """Return the processor time that an associator takes for a tick, µs."""
    times = []
    for _ in range(REPEATS):
        began = time.process_time()
        for pairs in kept:
            associator.probabilities(pairs)
        times.append(time.process_time() - began)
    return 1e6 * min(times) / max(len(kept), 1)
