"""Offsets of the cameras' clocks, estimated while targets move in several views."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.fusion.clock_offsets.moments import (
    BLOCK_S,
    MARGIN_S,
    BySet,
    joined,
    moments_of,
)
from mctrack_ros.fusion.clock_offsets.sightings import SIGHTING, reported, sightings
from mctrack_ros.fusion.clock_offsets.solution import Check, Solution, solve
from mctrack_ros.interfaces import Detections, RowsTick, Stamped, Tracks, starts_anew

Floats = NDArray[np.float64]

STEPS = 6
"""Of shifting the stamps and comparing anew."""
SETTLED_S = 0.002
"""Stamps that would be shifted by less stay, s."""
LONGEST_STEP_S = 0.3
GUIDING_S = 0.25
"""Stamps are not shifted by an offset whose interval is wider to either side, s."""
WIDE_S = 0.1
"""An interval that is wider to either side says that there was not enough motion, s."""


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """
    A camera's clock beside that of a reference.

    Attributes
    ----------
    camera, reference : str
        Their names; empty: nobody shares views with the camera.
    offset_s : float
        By how much the camera's stamps are ahead, s; NaN without a reference.
    deviation_s : float
        Standard deviation of that, s.
    half_s : float
        Half the width of its 95 % interval, s; infinite: nothing is known.

    """

    camera: str
    reference: str
    offset_s: float
    deviation_s: float
    half_s: float

    @property
    def is_known(self) -> bool:
        """Whether there was motion enough in common views."""
        return self.half_s <= WIDE_S


class Snapshot(NamedTuple):
    """
    What counts for an estimate.

    Attributes
    ----------
    run : int
        Counts how often time began anew.
    first : int
        Number of the first block.
    blocks : tuple of (k,) arrays of `SIGHTING`
        One after the other; the last is not complete.

    """

    run: int
    first: int
    blocks: tuple[NDArray[np.void], ...]


class ClockOffsets:
    """
    Collects what cameras see of targets; of this, `estimate` tells how their clocks differ.

    The last minutes count: cost and memory are bounded by them.

    Parameters
    ----------
    cameras : sequence of str
        Names in the site's order.
    window_s : float
        For how long a sighting counts, s.

    """

    def __init__(self, cameras: Sequence[str], window_s: float) -> None:
        self._index = {name: index for index, name in enumerate(cameras)}
        self._blocks: deque[NDArray[np.void]] = deque(maxlen=max(round(window_s / BLOCK_S), 1))
        self._solver, self._run = ClockSolver(cameras), 0
        self._forget()

    @property
    def sightings(self) -> int:
        """How many sightings count."""
        return sum(map(len, self._blocks)) + sum(map(len, self._open))

    def add(self, tick: RowsTick[Any], tracks: Tracks) -> bool:
        """
        Take a tick and the tracks after it.

        What fusion added to a camera's stamps is taken off again: the estimate is of the stamps
        as they came, whatever is corrected meanwhile.

        Returns
        -------
        bool
            Whether a block is complete: an estimate knows more than before.

        """
        begin_ns, record = self._started(tracks.stamp_ns), tick.record
        added_s = dict(zip(record.camera.tolist(), (record.added_ms * 1e-3).tolist()))
        for message in tick.messages:
            detections = _detections(message.rows)
            if detections is None:
                continue
            camera = self._index[message.camera]
            found = sightings(tracks, detections, camera, begin_ns)
            found['seconds'] -= added_s.get(camera, 0.0)
            self._open.append(found)
        return self._closed(tracks.stamp_ns)

    def add_reported(self, camera: str, detections: Detections) -> bool:
        """Take an image whose camera names the targets; see `add`."""
        begin_ns = self._started(detections.stamp_ns)
        self._open.append(reported(detections, self._index[camera], begin_ns))
        return self._closed(detections.stamp_ns)

    def snapshot(self) -> Snapshot:
        """Return what counts now; it does not change when more is added."""
        first = self._number - len(self._blocks)
        return Snapshot(self._run, first, (*self._blocks, _joined(self._open)))

    def estimate(
        self, snapshot: Snapshot | None = None, check: Check = lambda: None
    ) -> tuple[ClockOffset, ...]:
        """Return the offset of each camera, now or of a snapshot; see `ClockSolver.solve`."""
        return self._solver.solve(snapshot or self.snapshot(), check)

    def _forget(self) -> None:
        """Begin anew."""
        self._begin_ns: int | None = None
        self._open: list[NDArray[np.void]] = []
        self._blocks.clear()
        self._number, self._last_ns = 0, 0
        self._run += 1

    def _started(self, stamp_ns: int) -> int:
        if self._begin_ns is not None and starts_anew(stamp_ns, self._last_ns):
            self._forget()
        if self._begin_ns is None:
            self._begin_ns = stamp_ns
        self._last_ns = max(stamp_ns, self._last_ns)
        return self._begin_ns

    def _closed(self, stamp_ns: int) -> bool:
        assert self._begin_ns is not None
        number = int((stamp_ns - self._begin_ns) * 1e-9 / BLOCK_S)
        if number <= self._number:
            return False
        for _ in range(min(number - self._number, self._blocks.maxlen or 1)):
            self._blocks.append(_joined(self._open))
            self._open = []
        self._number = number
        return True


class ClockSolver:
    """
    Estimates how the cameras' clocks differ, beside a constant bias of each on the ground.

    Of two cameras that see one target, that whose clock is ahead shows it where it was shortly
    before. Stamps are shifted by what is known, and the cameras compared anew, until they agree
    (Gauss-Newton). What was compared before is kept: later estimates begin there.

    Parameters
    ----------
    cameras : sequence of str
        Names in the site's order.

    """

    def __init__(self, cameras: Sequence[str]) -> None:
        self._cameras = tuple(cameras)
        self._compared: dict[int, BySet] = {}
        self._ahead = np.zeros(len(cameras))
        self._run = 0

    def solve(self, snapshot: Snapshot, check: Check = lambda: None) -> tuple[ClockOffset, ...]:
        """
        Return the offset of each camera, in the site's order.

        The reference is the camera whose clock is in the middle of those that have common views;
        of two, the first. With many cameras it takes seconds: `check` is called again and again,
        and what it raises ends the estimate.
        """
        if snapshot.run != self._run:
            self._run, self._ahead = snapshot.run, np.zeros(len(self._cameras))
            self._compared.clear()
        for _ in range(STEPS):
            solution = solve(joined(self._moments(snapshot, check)), len(self._cameras), check)
            step = self._step(solution)
            if np.abs(step).max(initial=0.0) < SETTLED_S:
                break
            self._ahead += step
            self._compared.clear()
        return tuple(self._offset(solution, index) for index in range(len(self._cameras)))

    def _moments(self, snapshot: Snapshot, check: Check) -> Iterator[BySet]:
        """Yield the moments of each block; those that no sighting adds to are kept."""
        _, first, blocks = snapshot
        self._compared = {key: kept for key, kept in self._compared.items() if key >= first}
        for index in range(len(blocks)):
            check()
            number = first + index
            found = self._compared.get(number)
            if found is None:
                near = _joined(blocks[max(index - 1, 0) : index + 2])
                near['seconds'] -= self._ahead[near['camera']]
                away_s = near['seconds'] - number * BLOCK_S
                near = near[(away_s > -MARGIN_S) & (away_s < BLOCK_S + MARGIN_S)]
                found = moments_of(near, number)
                if index + 2 < len(blocks):
                    self._compared[number] = found
            yield found

    def _step(self, solution: Solution) -> Floats:
        """Return by what stamps are to be shifted more, s."""
        step = np.zeros(len(self._cameras))
        for camera, group in enumerate(solution.group.tolist()):
            if group >= 0:
                offset, _, half = solution.between(camera, group)
                if half < GUIDING_S:
                    step[camera] = np.clip(offset, -LONGEST_STEP_S, LONGEST_STEP_S)
        return step

    def _offset(self, solution: Solution, camera: int) -> ClockOffset:
        """Return a camera's offset from the one whose clock is in the middle of its group."""
        group = solution.group[camera]
        if group < 0:
            return ClockOffset(self._cameras[camera], '', np.nan, np.inf, np.inf)
        total = self._ahead + solution.offset
        middle = self._middle(solution, total, int(group))
        _, deviation, half = solution.between(camera, middle)
        offset = float(total[camera] - total[middle])
        return ClockOffset(self._cameras[camera], self._cameras[middle], offset, deviation, half)

    def _middle(self, solution: Solution, total: Floats, group: int) -> int:
        """Return the camera whose clock is in the middle of those that are known in a group."""
        members = [
            camera
            for camera in np.flatnonzero(solution.group == group).tolist()
            if solution.between(camera, group)[2] < GUIDING_S
        ]
        members.sort(key=lambda camera: total[camera])
        return min(members[(len(members) - 1) // 2], members[len(members) // 2])


def _detections(rows: Stamped) -> Detections | None:
    """Return the detections of an image: all that there is, or beside others; None: none."""
    found: Any = rows if isinstance(rows, Detections) else getattr(rows, 'detections', None)
    return found if isinstance(found, Detections) else None


def _joined(parts: Sequence[NDArray[np.void]]) -> NDArray[np.void]:
    return np.concatenate([np.zeros(0, SIGHTING), *parts])
