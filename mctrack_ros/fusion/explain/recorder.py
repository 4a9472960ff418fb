"""Takes down why one tick was decided as it was, for whoever asks."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.fusion.association.gating import distances
from mctrack_ros.fusion.association.scored_pairs import JudgedPairs
from mctrack_ros.fusion.explain.decisions import decisions_of
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.measurements.admission import usable_rows
from mctrack_ros.fusion.measurements.batch import Batch
from mctrack_ros.fusion.reid.reassignment import Reassignment
from mctrack_ros.fusion.table import TrackTable
from mctrack_ros.interfaces import Candidates, Choice, Explanation, Tick
from mctrack_ros.tracking.kalman import position_matrix

Indices = NDArray[np.intp]


class DecisionRecorder:
    """
    What is taken down of one tick while the pipeline steps through it.

    Give a new one to `JointTracker.step`, then ask for its `explanation`. It changes
    nothing.

    Attributes
    ----------
    explanation : Explanation
        Once the tick is done.

    """

    explanation: Explanation

    def begin(
        self,
        tick: Tick,
        table: TrackTable,
        ended: TrackTable,
        config: JointConfig,
        cameras: tuple[str, ...],
    ) -> None:
        """Note the tick, its predicted tracks, and those that a step back in time has ended."""
        self._stamp_ns, self._config = tick.stamp_ns, config
        self._predicted = table.select(np.arange(len(table)))
        self._reset_ids = ended.track_id.copy()
        usable = [np.flatnonzero(usable_rows(message.rows)) for message in tick.messages]
        self._detection = np.concatenate([np.empty(0, np.intp), *usable])
        self._weighed: list[Candidates] = []

    def pairs(self, pairs: JudgedPairs, table: TrackTable, batch: Batch) -> None:
        """Note the pairs of tracks and detections, before the table learns of them."""
        near = pairs.squared < self._config.association.gate
        chosen = np.where(near, Choice.PASSED_OVER, Choice.BEYOND)
        self._note(
            batch,
            pairs.row,
            track_id=table.track_id[pairs.track],
            choice=np.where(pairs.taken, Choice.TAKEN, chosen),
            expected=pairs.place,
            expected_covariance=pairs.spread,
            squared_distance=pairs.squared,
            probability=pairs.probability,
            **pairs.costs,
        )

    def hidden(
        self,
        members: Indices,
        group: int,
        squared: NDArray[np.float64],
        table: TrackTable,
        batch: Batch,
    ) -> None:
        """Note the tracks (k,) that a detection of several is taken to hide."""
        matrix = position_matrix(batch.seconds[batch.image[group]])
        self._note(
            batch,
            np.full(len(members), group),
            track_id=table.track_id[members],
            choice=np.full(len(members), Choice.HIDES),
            expected=table.mean[members] @ matrix.T,
            expected_covariance=matrix @ table.covariance[members] @ matrix.T,
            squared_distance=squared,
        )

    def left(self, rows: Indices, table: TrackTable, batch: Batch) -> None:
        """Note the detections (k,) that no track took, and which of the new tracks they begin."""
        fresh = table.select(~np.isin(table.track_id, self._predicted.track_id))
        name = np.zeros(len(rows), np.uint32)
        if len(fresh) and len(rows):
            squared = distances(
                fresh.mean,
                fresh.covariance,
                batch.seconds[batch.image[rows]],
                batch.position[rows],
                batch.noise[rows],
            )
            squared[(fresh.cameras >> batch.camera[rows, None]) & 1 == 0] = np.inf
            nearest = squared.argmin(axis=1)
            begins = np.isfinite(squared[np.arange(len(rows)), nearest])
            name = np.where(begins, fresh.track_id[nearest], 0)
        begins = name > 0
        self._note(
            batch,
            rows[begins],
            track_id=name[begins],
            choice=np.full(int(begins.sum()), Choice.BEGINS),
        )
        noted = [each.detection for each in self._weighed]
        unused = np.setdiff1d(np.arange(len(batch.image)), np.concatenate(noted))
        self._note(batch, unused, choice=np.full(len(unused), Choice.UNUSED))

    def end(self, table: TrackTable, ended: TrackTable, recognition: Reassignment) -> None:
        """Note what came of it, and who is called what now."""
        decisions, called = decisions_of(
            table,
            ended,
            self._predicted,
            self._reset_ids,
            recognition,
            self._stamp_ns,
            self._config,
        )
        candidates = Candidates.joined(self._stamp_ns, self._weighed)
        names = [called.get(one, one) for one in candidates.track_id.tolist()]
        candidates = candidates.replace(
            track_id=np.array(names, np.uint32),
            detection=self._detection[candidates.detection],
        )
        order = np.lexsort(
            (candidates.detection, candidates.seconds, candidates.camera, candidates.track_id)
        )
        self.explanation = Explanation(candidates.select(order), decisions)

    def _note(self, batch: Batch, rows: NDArray[np.integer], **columns: ArrayLike) -> None:
        """Add candidates, one for each of the (k,) detections."""
        detections = batch.detections
        self._weighed.append(
            Candidates.build(
                self._stamp_ns,
                position=detections.position[rows],
                covariance=batch.noise[rows],
                seconds=batch.seconds[batch.image[rows]],
                local_id=detections.local_id[rows],
                told_id=detections.track_id[rows],
                detection=rows,
                camera=batch.camera[rows],
                member_count=detections.member_count[rows],
                **{name: _finite(values) for name, values in columns.items()},
            )
        )


def _finite(values: ArrayLike) -> NDArray[np.generic]:
    """Return numbers with NaN in place of what is infinite: that does not travel."""
    array = np.asarray(values)
    if array.dtype.kind != 'f':
        return array
    return np.where(np.abs(array) < np.finfo(np.float32).max, array, np.nan)
