"""Events against true events: which were told, in time and of the same targets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from mctrack_ros.evaluation.frames import ground_distance, matched
from mctrack_ros.interfaces import Detections, EventCode, Events, Tracks

CODES = (EventCode.NEW, EventCode.ENTER, EventCode.SPLIT, EventCode.EXIT, EventCode.MERGE)
"""E1 to E5."""

DOUBTFUL = 0.8
"""Events that are told as less probable are counted apart."""


@dataclass(frozen=True, slots=True)
class Happening:
    """
    One event of one camera.

    Attributes
    ----------
    stamp_ns : int
        When, ns.
    event : int
        An `EventCode`.
    targets : frozenset of int
        Everybody concerned: whom it is about and the others of the group; true ids.
    probability : float
        How probable it was told to be.

    """

    stamp_ns: int
    event: int
    targets: frozenset[int]
    probability: float = 1.0


@dataclass(frozen=True, slots=True)
class EventScore:
    """
    How well events of one kind were told.

    Attributes
    ----------
    true, told, hits : int
        True events, told events, and pairs of both.
    expected : float
        Hits that the told events promised: the sum of their probabilities.
    doubted, doubted_hits : int
        Told events that were less probable than `DOUBTFUL`, and pairs of them.

    """

    true: int = 0
    told: int = 0
    hits: int = 0
    expected: float = 0.0
    doubted: int = 0
    doubted_hits: int = 0

    def __add__(self, other: EventScore) -> EventScore:
        """Return the score of both together."""
        return EventScore(*(one + more for one, more in zip(astuple(self), astuple(other))))

    @property
    def ratio(self) -> float:
        """Told events over true ones (event-tracking paper, eq. (6)); false ones flatter it."""
        return self.told / self.true if self.true else float('nan')

    @property
    def precision(self) -> float:
        """Share of the told events that are true."""
        return self.hits / self.told if self.told else float('nan')

    @property
    def promised(self) -> float:
        """Share of the told events that would be true, had each been as probable as told."""
        return self.expected / self.told if self.told else float('nan')

    @property
    def doubted_precision(self) -> float:
        """Share of those told as less probable than `DOUBTFUL` that are true."""
        return self.doubted_hits / self.doubted if self.doubted else float('nan')

    @property
    def recall(self) -> float:
        """Share of the true events that are told."""
        return self.hits / self.true if self.true else float('nan')

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        both = self.true + self.told
        return 2 * self.hits / both if both else float('nan')


def score_events(
    true: Sequence[Happening], told: Sequence[Happening], window_s: float, alike: float
) -> EventScore:
    """
    Pair events of one kind and camera, as many as possible, each once.

    Parameters
    ----------
    true, told : sequence of Happening
        Events.
    window_s : float
        Largest difference in time of a pair, s.
    alike : float
        Least share of the targets of either that both name; 1: the same targets.

    """
    probability = np.array([one.probability for one in told])
    doubted = probability < DOUBTFUL
    counts = len(true), len(told)
    if not true or not told:
        return EventScore(*counts, 0, float(probability.sum()), int(doubted.sum()))
    apart = np.abs(np.subtract.outer(_stamps(true), _stamps(told)))
    usable = apart <= round(window_s * 1e9)
    for row, column in np.argwhere(usable).tolist():
        one, other = true[row].targets, told[column].targets
        usable[row, column] = len(one & other) >= alike * len(one | other)
    rows, columns = linear_sum_assignment(usable, maximize=True)
    hit = columns[usable[rows, columns]]
    promised = float(probability.sum())
    return EventScore(*counts, len(hit), promised, int(doubted.sum()), int(doubted[hit].sum()))


def true_happenings(events: Iterable[Events]) -> list[Happening]:
    """Return a camera's true events, whose ids are the targets' own."""
    return [
        Happening(rows.stamp_ns, int(rows.event[row]), frozenset(_named(rows, row)))
        for rows in events
        for row in range(len(rows))
    ]


def told_happenings(
    events: Iterable[Events], people: People, everybody: People
) -> list[Happening]:
    """
    Return a camera's events, with true ids instead of its own.

    Parameters
    ----------
    events : iterable of Events
        Of the camera.
    people : People
        Whom its local tracks stand for.
    everybody : People
        Whom the global tracks stand for: members of groups, and targets without a local track.

    """
    told = []
    for rows in events:
        for row in np.flatnonzero(np.isin(rows.event, CODES)).tolist():
            in_group = rows.others[row].any() or rows.other_tracks[row].any()
            local_ids = [rows.local_id[row], *rows.others[row]]
            track_ids = [rows.track_id[row], *rows.other_tracks[row]]
            named = frozenset(
                everybody.at(int(track), rows.stamp_ns)
                if track and (in_group or not local)
                else people.at(int(local), rows.stamp_ns)
                for local, track in zip(local_ids, track_ids)
                if local or track
            )
            code, probability = int(rows.event[row]), float(rows.probability[row])
            told.append(Happening(rows.stamp_ns, code, named, probability))
    return told


class People:
    """
    Whom the tracks of one camera, or of the fusion node, stand for, by where they are.

    Parameters
    ----------
    truth, found : iterable of Detections or of Tracks
        In the order of time; ``track_id`` of the truth is the true id.
    gate_m : float
        Largest distance of a person and a detection, m.
    memory_s : float
        A track stands for whom it was matched to most often within this time, s.
    field : str
        Of what was found, that holds the tracks' ids.

    """

    def __init__(
        self,
        truth: Iterable[Detections | Tracks],
        found: Iterable[Detections | Tracks],
        gate_m: float,
        memory_s: float,
        field: str = 'local_id',
    ) -> None:
        self._memory_ns = round(memory_s * 1e9)
        self._seen: dict[int, list[tuple[int, int]]] = {}
        true_rows = {rows.stamp_ns: rows for rows in truth}
        for rows in found:
            rows = rows.select(rows.member_count == 1)
            there = true_rows.get(rows.stamp_ns)
            if there is None or not len(rows) or not len(there):
                continue
            apart = ground_distance(_ground(there), _ground(rows))
            mine, theirs = matched(np.nan_to_num(apart, nan=np.inf), gate_m)
            for person, local in zip(there.track_id[mine], getattr(rows, field)[theirs]):
                self._seen.setdefault(int(local), []).append((rows.stamp_ns, int(person)))

    def at(self, track: int, stamp_ns: int) -> int:
        """Return the true id of whom a track stands for at a time; below 0: for nobody."""
        seen = self._seen.get(track)
        if not seen:
            return -track
        near = Counter(
            person for when_ns, person in seen if abs(when_ns - stamp_ns) <= self._memory_ns
        )
        if near:
            return near.most_common(1)[0][0]
        return min(seen, key=lambda sight: abs(sight[0] - stamp_ns))[1]


def _stamps(happenings: Sequence[Happening]) -> NDArray[np.int64]:
    return np.array([happening.stamp_ns for happening in happenings], np.int64)


def _ground(rows: Detections | Tracks) -> NDArray[np.float64]:
    return rows.position[:, :2].astype(np.float64)


def _named(rows: Events, row: int) -> list[int]:
    """Return the true ids that a true event names."""
    return [int(rows.track_id[row]), *rows.others[row][rows.others[row] > 0].tolist()]
