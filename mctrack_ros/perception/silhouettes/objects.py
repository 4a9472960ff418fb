"""Step 8: the list of objects, brought up to date with what was matched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mctrack_ros.config import parameter
from mctrack_ros.perception.blobs.extraction import overlap
from mctrack_ros.perception.local_tracks.parallel_arrays import ParallelArrays
from mctrack_ros.perception.silhouettes.features import (
    PLACE,
    SIZE,
    Floats,
    Ints,
    Mask,
    Shapes,
)

HIDDEN = 0.2  # share of an expected box from which it counts as hidden in a silhouette


@dataclass(frozen=True)
class ObjectConfig:
    """Parameters of `ObjectList`."""

    least_area_px: float = parameter(
        60.0, 'smallest silhouette that becomes an object [px²]', minimum=1.0
    )
    edge_px: float = parameter(
        16.0, "distance from the image's edge within which what is lost has left [px]",
        minimum=0.0,
    )  # fmt: skip
    establish_s: float = parameter(
        1.15,
        'age from which an object that is matched again is no longer transient; two images at '
        'the 4 Hz of the paper [s]',
        minimum=0.0,
    )
    move_px: float = parameter(
        6.0,
        'distance that it must have come by then, which holes and false foreground do not; 0: '
        'as printed [px]',
        minimum=0.0,
    )
    hold_s: float = parameter(
        4.0, 'time that an established object stays without a match; 0: as printed [s]',
        minimum=0.0,
    )  # fmt: skip
    body_s: float = parameter(
        2.0,
        'time that an object must have been seen whole and alone to share a silhouette with one '
        'that has; 0: as printed [s]',
        minimum=0.0,
    )
    hidden_s: float = parameter(
        15.0,
        'the same while it is expected within what several others or a vehicle make up [s]',
        minimum=0.0,
    )
    memory_s: float = parameter(
        0.7,
        'time constant with which features follow the silhouette; 0: at once, as printed [s]',
        minimum=0.0,
    )
    motion_s: float = parameter(
        0.5,
        'time constant with which the velocity is learned that tells where an object is expected; '
        '0: where it was, as printed [s]',
        minimum=0.0,
    )


class ObjectList(ParallelArrays):
    """
    What is tracked, as parallel arrays, by id.

    Attributes
    ----------
    vector, box : (n, 21), (n, 4) float64 arrays
        Shapes as in `Shapes`; of the last silhouette, the place moved to where it is expected.
    velocity : (n, 2) float64 array
        Of the centroid, px/s; zero if motion is not learned.
    first_ns, seen_ns : (n,) int64 array
        Time of the first and the last match.
    missed_s : (n,) float64 array
        For how long it was not seen though nothing hid it, s.
    coherent_ns : (n,) int64 array
        Since when it was matched in every image.
    matched, established : (n,) bool array
        Matched in this image; no longer transient.
    alone_s : (n,) float64 array
        For how long it was seen whole, in a silhouette of its own, s.
    group : (n,) int64 array
        Number of the merged silhouette it is in; 0: it has one of its own.
    track_id : (n,) int64 array
        Global id that feedback taught; 0: none.
    mean, covariance : (n, 4), (n, 4, 4) float64 arrays
        x, y (m) on the ground where it was last seen, NaN above the horizon; no velocity.
    class_id : (n,) int64 array
        A `ClassCode`.
    announced : (n,) bool array
        Its first event was sent.
    origin : (n, 2) float64 array
        Where it was first seen, px.
    travelled_px : (n,) float64 array
        How far from there it has been, px.

    """

    vector: Floats = np.zeros(SIZE)
    box: Floats = np.zeros(4)
    velocity: Floats = np.zeros(2)
    first_ns: Ints = np.zeros((), np.int64)
    seen_ns: Ints = np.zeros((), np.int64)
    missed_s: Floats = np.zeros(())
    coherent_ns: Ints = np.zeros((), np.int64)
    matched: Mask = np.ones((), np.bool_)
    established: Mask = np.zeros((), np.bool_)
    alone_s: Floats = np.zeros(())
    group: Ints = np.zeros((), np.int64)
    track_id: Ints = np.zeros((), np.int64)
    mean: Floats = np.full(4, np.nan)
    covariance: Floats = np.eye(4)
    class_id: Ints = np.zeros((), np.int64)
    announced: Mask = np.zeros((), np.bool_)
    origin: Floats = np.zeros(2)
    travelled_px: Floats = np.zeros(())

    def __init__(self, config: ObjectConfig) -> None:
        self._config = config
        super().__init__()

    @property
    def confirmed(self) -> Mask:
        """Which objects, (n,), may learn a global id."""
        return self.established

    @property
    def shapes(self) -> Shapes:
        """What the objects look like and where they are expected."""
        return Shapes(self.vector, self.box)

    def predict(self, seconds: float) -> None:
        """Move all objects to where they are expected."""
        shift = self.velocity * seconds
        self.vector[:, PLACE] += shift
        self.box[:, :2] += shift

    def update(
        self, shapes: Shapes, match: Mask, covers: Mask, stamp_ns: int, seconds: float
    ) -> Mask:
        """
        Give objects the features of their silhouettes.

        Parameters
        ----------
        shapes : Shapes
            Of m silhouettes.
        match : (n, m) bool array
            At most one a row and a column.
        covers : (m,) bool array
            Which silhouettes are larger than one body, so that others may be hidden in them.
        stamp_ns : int
            Time of the image, ns.
        seconds : float
            Since the last image.

        Returns
        -------
        (n,) bool array
            Which objects are lost: without a silhouette for too long.

        """
        self.matched = np.asarray(match.any(axis=1))
        rows, columns = np.nonzero(match)
        self._learn_motion(rows, shapes.centroid[columns], seconds)
        self._learn_shapes(rows, shapes.select(columns), seconds)
        self.seen_ns[rows] = stamp_ns
        self.coherent_ns[~self.matched] = stamp_ns
        self._establish(stamp_ns)
        hidden = self._hidden_in(shapes.box[columns[covers[columns]]])
        self.missed_s = np.where(self.matched, 0.0, self.missed_s + seconds * ~hidden)
        return np.asarray(~self.matched & ~self._awaited(stamp_ns))

    def start(self, shapes: Shapes, stamp_ns: int) -> None:
        """Start a transient object for each silhouette."""
        if len(shapes):
            now = np.full(len(shapes), stamp_ns)
            times = dict.fromkeys(('first_ns', 'seen_ns', 'coherent_ns'), now)
            self.append(
                len(shapes), vector=shapes.vector, box=shapes.box, origin=shapes.centroid, **times
            )

    def keep(self, mask: Mask) -> None:
        """Keep the objects that a mask, (n,), picks."""
        if not mask.all():
            super().keep(mask)

    def _awaited(self, stamp_ns: int) -> Mask:
        """Tell who may still come back; who is hardly known, for as long as he has been."""
        unseen_s, known_s = (stamp_ns - self.seen_ns) * 1e-9, (self.seen_ns - self.first_ns) * 1e-9
        known_s[self.alone_s >= self._config.body_s] = np.inf
        hold_s, hidden_s = self._config.hold_s, self._config.hidden_s
        awaited = (self.missed_s <= np.fmin(known_s, hold_s)) & (
            unseen_s <= np.fmin(known_s, max(hold_s, hidden_s))
        )
        return np.asarray(self.established & awaited)

    def _hidden_in(self, box: Floats) -> Mask:
        """Tell whose expected middle, (n,), is in one of some boxes."""
        middle = (self.box[:, :2] + self.box[:, 2:] / 2)[:, None]
        inside = (middle >= box[:, :2]) & (middle <= box[:, :2] + box[:, 2:])
        return np.asarray(np.any(np.all(inside, axis=2), axis=1))

    def _hides_others(self, rows: Ints, box: Floats) -> Mask:
        """Tell in which silhouettes' boxes other objects are expected, whose features mix in."""
        if self._config.memory_s == 0.0:
            return np.zeros(len(rows), np.bool_)
        covered = overlap(box, self.box) / np.maximum(self.box[:, 2:].prod(axis=1), 1.0)
        covered[np.arange(len(rows)), rows] = 0.0
        return np.asarray((covered > HIDDEN).any(axis=1))

    def _learn_motion(self, rows: Ints, centroid: Floats, seconds: float) -> None:
        """Let velocities follow how far the silhouettes lie from where they were expected."""
        if self._config.motion_s == 0.0 or seconds <= 0.0:
            return
        missed = centroid - self.vector[rows][:, PLACE]
        self.velocity[rows] += _share(seconds, self._config.motion_s) * missed / seconds

    def _learn_shapes(self, rows: Ints, found: Shapes, seconds: float) -> None:
        """Let the features of objects follow those of their silhouettes; places at once."""
        share = (
            _share(seconds, self._config.memory_s) * ~self._hides_others(rows, found.box)[:, None]
        )
        learned = self.vector[rows] + share * (found.vector - self.vector[rows])
        learned[:, PLACE] = found.centroid
        self.vector[rows], self.box[rows] = learned, found.box

    def _establish(self, stamp_ns: int) -> None:
        """End the transience of matched objects that are old enough and have come far enough."""
        old = stamp_ns - self.first_ns >= round(self._config.establish_s * 1e9)
        apart = self.shapes.centroid - self.origin
        self.travelled_px = np.maximum(self.travelled_px, np.hypot(apart[:, 0], apart[:, 1]))
        came = self.travelled_px >= self._config.move_px
        self.established[self.matched & old & came] = True


def _share(seconds: float, time_constant_s: float) -> float:
    """Return the share of a difference that is learned in some time."""
    return 1.0 if time_constant_s == 0.0 else 1 - float(np.exp(-seconds / time_constant_s))


def at_edge(box: Floats, size: tuple[int, ...], margin_px: float) -> Mask:
    """Tell which (n, 4) boxes come as near to the edge of a (height, width) image."""
    low, high = box[:, :2], box[:, :2] + box[:, 2:]
    beyond = (low <= margin_px) | (high >= np.array(size[::-1]) - margin_px)
    return np.asarray(beyond.any(axis=1))
