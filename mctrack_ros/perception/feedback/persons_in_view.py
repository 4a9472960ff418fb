"""People in a camera's view: its own tracks and the fusion node's targets, each once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_1D, FLOATS_2D, INTS_1D, compiled, inner
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception.geometry.person_size import SizeTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
NO_FEEDBACK = Feedback.build(0)


SAME_M = 1.0
"""Distance within which a local track and a target may be one person: twice a person's width."""
SURE_S, SURE_SHARE = 0.4, 0.35
"""Age, s, and share of the body that it must explain alone, from which a local track that is no
target is a person; by trial on simulated matches."""
MEMORY_S = 1.0
"""Time for which targets are predicted without new feedback: many periods of the fusion node."""


@dataclass(frozen=True, eq=False, slots=True)
class ConfirmedTracks:
    """
    Confirmed local tracks, as they are seen in one image, one row each.

    Attributes
    ----------
    local_id : (n,) int64 array
        Ascending.
    position : (n, 2) float64 array
        Where they are expected, m.
    box : (n, 4) float64 array
        Left, top, width, height, px.
    seen : (n,) bool array
        In this image.
    proven : (n,) float64 array
        Share of the body that is foreground which no older track explains.
    age_s : (n,) float64 array
        Since they began, s.

    """

    local_id: Ints
    position: Floats
    box: Floats
    seen: Booleans
    proven: Floats
    age_s: Floats


NO_TRACKS = ConfirmedTracks(
    np.zeros(0, np.int64),
    np.zeros((0, 2)),
    np.zeros((0, 4)),
    np.zeros(0, np.bool_),
    np.zeros(0),
    np.zeros(0),
)


@dataclass(frozen=True, eq=False, slots=True)
class PersonsInView:
    """
    Persons in view, one row each, ascending by key.

    Attributes
    ----------
    key : (n,) int64 array
        The global id; minus the local one where there is none.
    local_id, track_id : (n,) int64 array
        The camera's own track and the global one; 0: none.
    position : (n, 2) float64 array
        On the ground, m.
    box : (n, 4) float64 array
        Where they are, or else should be, px; not finite: not seen.
    came : (n,) bool array
        Stepped into the image just now.

    """

    key: Ints
    local_id: Ints
    track_id: Ints
    position: Floats
    box: Floats
    came: Booleans


NO_PERSONS = PersonsInView(
    np.zeros(0, np.int64),
    np.zeros(0, np.int64),
    np.zeros(0, np.int64),
    np.zeros((0, 2)),
    np.zeros((0, 4)),
    np.zeros(0, np.bool_),
)


class PersonList:
    """
    Lists the fusion node's targets in view, and the local tracks that are none of them.

    A target without a local track, because others hide it, is listed all the same, where the
    fusion node expects him (event-tracking paper, R2, R3 and R5: what it knows is registered). A
    target and a local track are one by where they are now, not by what they were once.

    Parameters
    ----------
    extent : (2,) array
        Width and height of who is expected, m.
    sizes : SizeTable
        Of the camera.
    mapping : GroundMapping
        Of the camera.

    """

    def __init__(self, extent: Floats, sizes: SizeTable, mapping: GroundMapping) -> None:
        self._extent, self._sizes, self._mapping = extent, sizes, mapping
        self._image_size = np.array(mapping.image_size, np.float64)
        self.restart()

    def restart(self) -> None:
        """Forget who was in view."""
        self._feedback = NO_FEEDBACK
        self._outside: Ints = np.zeros(0, np.int64)

    def update(
        self, local: ConfirmedTracks, feedback: Feedback | None, stamp_ns: int
    ) -> PersonsInView:
        """
        Return who is in view.

        Parameters
        ----------
        local : ConfirmedTracks
            The camera's own tracks.
        feedback : Feedback or None
            The fusion node's; without, the last one counts for a while, then all local tracks do.
        stamp_ns : int
            Time of the image, ns.

        """
        if feedback is not None:
            self._feedback = feedback
        if (stamp_ns - self._feedback.stamp_ns) * 1e-9 > MEMORY_S:
            return self._alone(local)
        place = self._feedback.places(stamp_ns)
        foot = self._mapping.image_from_ground(place)
        sure = local.seen & (local.proven >= SURE_SHARE)
        sure &= local.age_s >= SURE_S
        key, local_id, track_id, position, box, came, self._outside = _joined(
            self._feedback.track_id.astype(np.int64),
            place,
            foot,
            self._sizes.box_of(foot, self._extent[None]),
            self._outside,
            local.local_id,
            local.position,
            local.box,
            self._sizes.foot_of(local.box),
            local.seen,
            sure,
            self._image_size,
        )
        return PersonsInView(key, local_id, track_id, position, box, came)

    def _alone(self, local: ConfirmedTracks) -> PersonsInView:
        """Return the persons in view as the camera knows them without the fusion node."""
        youngest_first = np.arange(len(local.local_id))[::-1]
        local_id = local.local_id[youngest_first]
        box = np.where(local.seen[:, None], local.box, np.nan)[youngest_first]
        nobody, came = np.zeros(len(box), np.int64), np.ones(len(box), np.bool_)
        return PersonsInView(
            -local_id, local_id, nobody, local.position[youngest_first], box, came
        )


@inner
def _pairs(place: Floats, position: Floats, seen: Booleans) -> Ints:
    """Return the local track that each target is, or -1: the nearest pairs first, each once."""
    gap = np.empty((len(place), len(position)))
    for one in range(len(place)):
        for other in range(len(position)):
            across = place[one, 0] - position[other, 0]
            far = np.hypot(across, place[one, 1] - position[other, 1])
            gap[one, other] = far if seen[other] else np.inf
    found, taken = np.full(len(place), -1), np.zeros(len(position), np.bool_)
    while True:
        least, nearest, to = SAME_M, -1, -1
        for one in range(len(place)):
            if found[one] >= 0:
                continue
            for other in range(len(position)):
                if gap[one, other] < least and not taken[other]:
                    least, nearest, to = gap[one, other], one, other
        if nearest < 0:
            return found
        found[nearest], taken[to] = to, True


@inner
def _is_inside(foot: Floats, size: Floats) -> bool:
    return bool(0 <= foot[0] <= size[0] and 0 <= foot[1] <= size[1])


@inner
def _insert(key: Ints, source: Ints, count: int, new: int, row: int) -> int:
    """Insert a key, and the row that it is of, into ascending ones; return how many there are."""
    place = count
    while place and key[place - 1] > new:
        key[place], source[place] = key[place - 1], source[place - 1]
        place -= 1
    key[place], source[place] = new, row
    return count + 1


@compiled(
    types.Tuple([types.i8[::1]] * 3 + [types.f8[:, ::1]] * 2 + [types.b1[::1], types.i8[::1]])(
        INTS_1D, FLOATS_2D, FLOATS_2D, FLOATS_2D, INTS_1D, INTS_1D, FLOATS_2D, FLOATS_2D,
        FLOATS_2D, BOOLS_1D, BOOLS_1D, FLOATS_1D,
    )
)  # fmt: skip
def _joined(
    target: Ints, place: Floats, foot: Floats, box: Floats, outside: Ints, local_id: Ints,
    position: Floats, local_box: Floats, local_foot: Floats, seen: Booleans, sure: Booleans,
    size: Floats,
) -> tuple[Ints, Ints, Ints, Floats, Floats, Booleans, Ints]:  # fmt: skip
    """Return the columns of `PersonsInView`, and the targets that are out of the image."""
    local_of = _pairs(place, position, seen)
    most = len(target) + len(local_id)
    key, local, track = (
        np.empty(most, np.int64),
        np.zeros(most, np.int64),
        np.zeros(most, np.int64),
    )
    source, left_out = np.empty(most, np.int64), np.empty(len(target), np.int64)
    alone, count, away = sure.copy(), 0, 0
    for one in range(len(target)):
        if local_of[one] >= 0:
            alone[local_of[one]] = False
        if _is_inside(foot[one], size):
            count = _insert(key, source, count, target[one], one)
        else:
            left_out[away] = target[one]
            away += 1
    for other in range(len(local_id)):
        if alone[other] and _is_inside(local_foot[other], size):
            count = _insert(key, source, count, -local_id[other], len(target) + other)
    where, boxes = np.empty((count, 2)), np.empty((count, 4))
    came = np.zeros(count, np.bool_)
    for row in range(count):
        one = source[row]
        other = one - len(target) if one >= len(target) else local_of[one]
        if other >= 0:
            local[row] = local_id[other]
        if one < len(target):
            track[row] = target[one]
            for index in range(len(outside)):
                came[row] |= outside[index] == target[one]
        for axis in range(2):
            where[row, axis] = place[one, axis] if one < len(target) else position[other, axis]
        for side in range(4):
            boxes[row, side] = box[one, side] if other < 0 else local_box[other, side]
    return key[:count], local[:count], track[:count], where, boxes, came, left_out[:away]
