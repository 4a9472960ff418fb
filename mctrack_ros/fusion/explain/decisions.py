"""What a tick has made of every track, and why: worked out from before and after."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.joint_tracker.output import ground_points, status_of
from mctrack_ros.fusion.management.lifecycle import is_published, patience, silence
from mctrack_ros.fusion.reid.reassignment import Reassignment
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import Decisions, Reason, TrackStatus

Mask = NDArray[np.bool_]
Floats = NDArray[np.float64]


def decisions_of(
    table: TrackTable,
    ended: TrackTable,
    predicted: TrackTable,
    reset_ids: NDArray[np.uint32],
    recognition: Reassignment,
    stamp_ns: int,
    config: JointConfig,
) -> tuple[Decisions, dict[int, int]]:
    """
    Tell what became of each track.

    Parameters
    ----------
    table, ended : TrackTable
        After the tick: those who are tracked, and those whose tracks ended.
    predicted : TrackTable
        Before its detections.
    reset_ids : (k,) uint32 array
        Ended because time stepped back.
    recognition : Reassignment
        Galleries, and who was found again.
    stamp_ns : int
        Of the tick, ns.
    config : JointConfig
        Parameters.

    Returns
    -------
    decisions : Decisions
        Sorted by id.
    called : dict of int to int
        What tracks are called now, by what they were called before, where that differs.

    """
    joined = _joined(table, ended, reset_ids)
    living = _Verdicts(table, stamp_ns)
    renamed = (table.previous_id > 0) & ~np.isin(table.previous_id, list(joined))
    living.previous_id[renamed] = table.previous_id[renamed]
    _judge_living(living, predicted, config)
    _judge_renamed(living, joined, recognition, config)
    over = _Verdicts(ended, stamp_ns)
    _judge_ended(over, joined, reset_ids, config)
    called = dict(zip(table.previous_id[renamed].tolist(), table.track_id[renamed].tolist()))
    reported, all_ended = is_published(table, stamp_ns, config), np.ones(len(ended), np.bool_)
    both = Decisions.joined(
        stamp_ns,
        [
            living.rows(predicted, stamp_ns, reported),
            over.rows(predicted, stamp_ns, all_ended, TrackStatus.DELETED),
        ],
    )
    return both.select(np.argsort(both.track_id, kind='stable')), called


class _Verdicts:
    """Reasons of some tracks, to be filled in: what is not said is that nothing supports them."""

    def __init__(self, table: TrackTable, stamp_ns: int) -> None:
        count = len(table)
        self.table = table
        self.reason = np.full(count, Reason.COASTS, np.uint8)
        self.value, self.limit = silence(table, stamp_ns), np.full(count, np.nan)
        self.other_id, self.previous_id = np.zeros(count, np.uint32), np.zeros(count, np.uint32)

    def former_id(self) -> NDArray[np.uint32]:
        """Return what each track was called before the tick, (n,)."""
        return np.where(self.previous_id > 0, self.previous_id, self.table.track_id)

    def say(
        self, rows: Mask | list[int], reason: Reason, value: ArrayLike, limit: ArrayLike
    ) -> None:
        """Give tracks a reason; later ones take the place of earlier ones."""
        self.reason[rows], self.value[rows], self.limit[rows] = reason, value, limit

    def rows(
        self,
        predicted: TrackTable,
        stamp_ns: int,
        reported: Mask,
        status: TrackStatus | None = None,
    ) -> Decisions:
        """Return the decisions, in the order of the tracks, of whom (n,) are published."""
        table, count = self.table, len(self.table)
        place, spread = np.full((count, 2), np.nan), np.full((count, 2, 2), np.nan)
        known, row = _known(self.former_id(), predicted)
        place[known], spread[known] = predicted.mean[row, :2], predicted.covariance[row, :2, :2]
        return Decisions.build(
            stamp_ns,
            position=ground_points(table),
            covariance=table.covariance[:, :2, :2],
            predicted=place,
            predicted_covariance=spread,
            velocity=table.mean[:, 2:],
            age=(stamp_ns - table.first_ns) / 1e9,
            unseen=(stamp_ns - table.seen_ns) / 1e9,
            unsupported=silence(table, stamp_ns),
            evidence=table.evidence,
            value=self.value,
            limit=self.limit,
            track_id=table.track_id,
            previous_id=self.previous_id,
            other_id=self.other_id,
            group=table.group,
            cameras=table.cameras,
            status=_status_of(table) if status is None else np.full(count, status),
            reason=self.reason,
            missed=table.missed,
            is_published=reported,
        )


def _status_of(table: TrackTable) -> list[int]:
    living = zip(table.confirmed.tolist(), table.cameras.tolist(), table.group.tolist())
    return [status_of(*each) for each in living]


def _known(
    track_id: NDArray[np.uint32], predicted: TrackTable
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which of some tracks were there before (k,), and their rows then (k,)."""
    known = np.flatnonzero(np.isin(track_id, predicted.track_id))
    return known, np.searchsorted(predicted.track_id, track_id[known])


def _joined(table: TrackTable, ended: TrackTable, reset_ids: NDArray[np.uint32]) -> dict[int, int]:
    """Return which of the ended tracks, by id, was a duplicate of which other one."""
    over = set(ended.track_id.tolist()) - set(reset_ids.tolist())
    reported = zip(table.previous_id.tolist(), table.track_id.tolist())
    return {old: new for old, new in reported if old in over}


def _judge_living(verdicts: _Verdicts, predicted: TrackTable, config: JointConfig) -> None:
    """Say of each track whether it is seen, hidden or coasts, whether it is new or confirmed."""
    table, confirm_evidence = verdicts.table, config.management.confirm_evidence
    verdicts.limit[:] = patience(table, config)
    known, row = _known(verdicts.former_id(), predicted)
    supported, begun = np.zeros(len(table), bool), np.ones(len(table), bool)
    supported[known] = table.kept_ns[known] > predicted.kept_ns[row]
    begun[known] = False
    confirmed = table.confirmed.copy()
    confirmed[known] &= ~predicted.confirmed[row]
    verdicts.say(supported, Reason.HIDDEN, np.nan, np.nan)
    verdicts.say(table.cameras > 0, Reason.SEEN, np.nan, np.nan)
    verdicts.say(begun, Reason.BEGAN, table.evidence[begun], confirm_evidence)
    verdicts.say(confirmed, Reason.CONFIRMED, table.evidence[confirmed], confirm_evidence)
    verdicts.other_id[begun | confirmed] = table.origin[begun | confirmed]


def _judge_renamed(
    verdicts: _Verdicts, joined: dict[int, int], recognition: Reassignment, config: JointConfig
) -> None:
    """Say of each track whose id was corrected why."""
    table = verdicts.table
    for row in np.flatnonzero(table.previous_id).tolist():
        old, new = int(table.previous_id[row]), int(table.track_id[row])
        verdicts.other_id[row] = old
        if old in joined:
            verdicts.say([row], Reason.ABSORBED, np.nan, np.nan)
            continue
        if verdicts.reason[row] == Reason.CONFIRMED and new in recognition.lost.found:
            verdicts.say([row], Reason.REAPPEARED, recognition.lost.found[new], 0.0)
        else:
            value, limit = recognition.differences(table, row, old)
            verdicts.say([row], Reason.RECOGNISED, value, limit)


def _judge_ended(
    verdicts: _Verdicts,
    joined: dict[int, int],
    reset_ids: NDArray[np.uint32],
    config: JointConfig,
) -> None:
    """Say why each track ended."""
    table = verdicts.table
    every = np.ones(len(table), bool)
    verdicts.say(every, Reason.SILENT, verdicts.value, patience(table, config))
    unseen = table.confirmed & (table.evidence < 0)
    verdicts.say(unseen, Reason.UNSEEN, table.evidence[unseen], 0.0)
    merged = np.isin(table.track_id, list(joined))
    verdicts.say(merged, Reason.JOINED, np.nan, np.nan)
    verdicts.other_id[merged] = [joined[one] for one in table.track_id[merged].tolist()]
    verdicts.say(np.isin(table.track_id, reset_ids), Reason.RESET, np.nan, np.nan)
