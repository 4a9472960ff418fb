"""People in a camera's view: its own tracks and the fusion node's targets, each once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

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
    own_share : (n,) float64 array
        Share of the body that is foreground which no older track explains.
    age_s : (n,) float64 array
        Since they began, s.

    """

    local_id: Ints
    position: Floats
    box: Floats
    seen: Booleans
    own_share: Floats
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

    @classmethod
    def joined(cls, parts: Sequence[PersonsInView]) -> PersonsInView:
        """Return the persons of all parts."""
        order = np.concatenate([part.key for part in parts]).argsort(kind='stable')
        names = [each.name for each in fields(cls)]
        columns = (np.concatenate([getattr(part, name) for part in parts]) for name in names)
        return cls(*(column[order] for column in columns))


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
        sure = local.seen & (local.own_share >= SURE_SHARE)
        sure &= local.age_s >= SURE_S
        local_of = _nearest_tracks(place, local.position, local.seen)
        sure[local_of[local_of >= 0]] = False
        targets = self._targets(local, local_of, place, foot)
        return PersonsInView.joined([targets, self._others(local, sure)])

    def _targets(
        self, local: ConfirmedTracks, local_of: Ints, place: Floats, foot: Floats
    ) -> PersonsInView:
        """List the targets in the image, each with the local track, (n,), that it is, or -1."""
        target = self._feedback.track_id.astype(np.int64)
        box, local_id = self._sizes.box_of(foot, self._extent[None]), np.zeros_like(target)
        tracked = local_of >= 0
        box[tracked] = local.box[local_of[tracked]]
        local_id[tracked] = local.local_id[local_of[tracked]]
        inside = self._is_inside(foot)
        came = np.isin(target, self._outside)[inside]
        self._outside = target[~inside]
        key = target[inside]
        return PersonsInView(key, local_id[inside], key, place[inside], box[inside], came)

    def _others(self, local: ConfirmedTracks, sure: Booleans) -> PersonsInView:
        """List the sure local tracks in the image, (n,), which are no targets."""
        rows = np.flatnonzero(sure & self._is_inside(self._sizes.foot_of(local.box)))
        own, nobody = local.local_id[rows], np.zeros(len(rows), np.int64)
        return PersonsInView(-own, own, nobody, local.position[rows], local.box[rows], nobody > 0)

    def _is_inside(self, foot: Floats) -> Booleans:
        """Tell which foot points, (n, 2) px, lie in the image."""
        return np.asarray(((foot >= 0) & (foot <= self._image_size)).all(axis=1))

    def _alone(self, local: ConfirmedTracks) -> PersonsInView:
        """Return the persons in view as the camera knows them without the fusion node."""
        youngest_first = np.arange(len(local.local_id))[::-1]
        local_id = local.local_id[youngest_first]
        box = np.where(local.seen[:, None], local.box, np.nan)[youngest_first]
        nobody, came = np.zeros(len(box), np.int64), np.ones(len(box), np.bool_)
        return PersonsInView(
            -local_id, local_id, nobody, local.position[youngest_first], box, came
        )


def _nearest_tracks(place: Floats, position: Floats, seen: Booleans) -> Ints:
    """Return the local track that each target is, or -1: the nearest pairs first, each once."""
    gap = np.where(seen, cdist(place, position), np.inf)
    one, other = np.nonzero(gap < SAME_M)
    found = np.full(len(place), -1)
    taken: set[int] = set()
    for pair in gap[one, other].argsort(kind='stable'):
        if found[one[pair]] < 0 and int(other[pair]) not in taken:
            found[one[pair]] = other[pair]
            taken.add(int(other[pair]))
    return found
