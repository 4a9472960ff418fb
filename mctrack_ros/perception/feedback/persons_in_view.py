"""Everybody in a camera's view: its own tracks and the fusion node's targets, each once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BOOLS_1D, FLOATS_1D, FLOATS_2D, INTS_1D, compiled, inner
from mctrack_ros.config import parameter
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception.geometry.person_size import SizeTable

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
NO_FEEDBACK = Feedback.build(0)


@dataclass(frozen=True)
class PersonsInViewConfig:
    """Parameters of `PersonList`."""

    same_m: float = parameter(
        1.0, 'distance within which a local track and a target may be one person [m]', minimum=0.0
    )
    sure_s: float = parameter(
        0.4, 'age from which a local track that is no target is a person [s]', minimum=0.0
    )
    sure_share: float = parameter(
        0.35,
        'share of the body that such a track must explain alone',
        minimum=0.0,
        maximum=1.0,
    )
    memory_s: float = parameter(
        1.0, 'time for which targets are predicted without new feedback [s]', minimum=0.0
    )


@dataclass(frozen=True, eq=False, slots=True)
class Sighting:
    """
    Local tracks that are believed, as they are seen in one image, one row each.

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
        Share of the body that explains what no older track does.
    age_s : (n,) float64 array
        Since they began, s.

    """

    local_id: Ints
    position: Floats
    box: Floats
    seen: Booleans
    proven: Floats
    age_s: Floats


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


NOBODY = PersonsInView(
    np.zeros(0, np.int64),
    np.zeros(0, np.int64),
    np.zeros(0, np.int64),
    np.zeros((0, 2)),
    np.zeros((0, 4)),
    np.zeros(0, np.bool_),
)


class PersonList:
    """
    Calls the roll: the fusion node's targets in view, and local tracks that are none of them.

    Who has no local track, because others hide him, is of the company all the same, where the
    fusion node expects him (event-tracking paper, R2, R3 and R5: what it knows is registered). A
    target and a local track are one by where they are now, not by what they were once.

    Parameters
    ----------
    config : PersonsInViewConfig
        Parameters.
    extent : (2,) array
        Width and height of who is expected, m.
    sizes : SizeTable
        Of the camera.
    mapping : GroundMapping
        Of the camera.

    """

    def __init__(
        self, config: PersonsInViewConfig, extent: Floats, sizes: SizeTable, mapping: GroundMapping
    ) -> None:
        self._config, self._extent = config, extent
        self._sizes, self._mapping = sizes, mapping
        self._image_size = np.array(mapping.image_size, np.float64)
        self.restart()

    def restart(self) -> None:
        """Forget who was in view."""
        self._feedback = NO_FEEDBACK
        self._outside: Ints = np.zeros(0, np.int64)

    def call(self, local: Sighting, feedback: Feedback | None, stamp_ns: int) -> PersonsInView:
        """
        Return who is in view.

        Parameters
        ----------
        local : Sighting
            The camera's own tracks.
        feedback : Feedback or None
            The fusion node's; without, the last one counts for a while, then all local tracks do.
        stamp_ns : int
            Time of the image, ns.

        """
        if feedback is not None:
            self._feedback = feedback
        if (stamp_ns - self._feedback.stamp_ns) * 1e-9 > self._config.memory_s:
            return self._alone(local)
        place = self._feedback.places(stamp_ns)
        foot = self._mapping.image_from_ground(place)
        sure = local.seen & (local.proven >= self._config.sure_share)
        sure &= local.age_s >= self._config.sure_s
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
            self._config.same_m,
        )
        return PersonsInView(key, local_id, track_id, position, box, came)

    def _alone(self, local: Sighting) -> PersonsInView:
        """Return the company as the camera knows it without the fusion node."""
        youngest_first = np.arange(len(local.local_id))[::-1]
        local_id = local.local_id[youngest_first]
        box = np.where(local.seen[:, None], local.box, np.nan)[youngest_first]
        nobody, came = np.zeros(len(box), np.int64), np.ones(len(box), np.bool_)
        return PersonsInView(
            -local_id, local_id, nobody, local.position[youngest_first], box, came
        )


@inner
def _pairs(place: Floats, position: Floats, seen: Booleans, same_m: float) -> Ints:
    """Return the local track that each target is, or -1: the nearest pairs first, each once."""
    gap = np.full((len(place), len(position)), np.inf)
    for one in range(len(place)):
        for other in range(len(position)):
            if not seen[other]:
                continue
            across = place[one, 0] - position[other, 0]
            gap[one, other] = np.hypot(across, place[one, 1] - position[other, 1])
    found = np.full(len(place), -1)
    while gap.size > 0:
        nearest = int(gap.argmin())
        one, other = nearest // gap.shape[1], nearest % gap.shape[1]
        if not gap[one, other] < same_m:
            break
        found[one] = other
        gap[one], gap[:, other] = np.inf, np.inf
    return found


@inner
def _is_inside(foot: Floats, size: Floats) -> bool:
    return bool(0 <= foot[0] <= size[0] and 0 <= foot[1] <= size[1])


@compiled(
    types.Tuple([types.i8[::1]] * 3 + [types.f8[:, ::1]] * 2 + [types.b1[::1], types.i8[::1]])(
        INTS_1D, FLOATS_2D, FLOATS_2D, FLOATS_2D, INTS_1D, INTS_1D, FLOATS_2D, FLOATS_2D,
        FLOATS_2D, BOOLS_1D, BOOLS_1D, FLOATS_1D, types.f8,
    )
)  # fmt: skip
def _joined(
    target: Ints, place: Floats, foot: Floats, box: Floats, outside: Ints, local_id: Ints,
    position: Floats, local_box: Floats, local_foot: Floats, seen: Booleans, sure: Booleans,
    size: Floats, same_m: float,
) -> tuple[Ints, Ints, Ints, Floats, Floats, Booleans, Ints]:  # fmt: skip
    """Return the columns of `PersonsInView`, and the targets that are out of the image."""
    local_of = _pairs(place, position, seen, same_m)
    inside = np.array([_is_inside(one, size) for one in foot], np.bool_)
    alone = sure.copy()
    alone[local_of[local_of >= 0]] = False
    for row in range(len(alone)):
        alone[row] = alone[row] and _is_inside(local_foot[row], size)
    targets, others = np.flatnonzero(inside), np.flatnonzero(alone)
    key = np.concatenate((target[targets], -local_id[others]))
    order, count = np.argsort(key), len(key)
    local, track = np.zeros(count, np.int64), np.zeros(count, np.int64)
    where, boxes = np.empty((count, 2)), np.empty((count, 4))
    came = np.zeros(count, np.bool_)
    for row in range(count):
        if order[row] >= len(targets):
            other = others[order[row] - len(targets)]
            local[row] = local_id[other]
            where[row], boxes[row] = position[other], local_box[other]
            continue
        one = targets[order[row]]
        track[row], where[row], boxes[row] = target[one], place[one], box[one]
        came[row] = (outside == target[one]).any()
        if local_of[one] >= 0:
            local[row], boxes[row] = local_id[local_of[one]], local_box[local_of[one]]
    return key[order], local, track, where, boxes, came, target[~inside]
