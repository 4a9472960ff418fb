"""Which events a scene had, and how many objects a tracker counted in each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mctrack_experiments.papers.silhouettes.activity import ActivityTable

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

ON_IT = 0.3
"""A track is on what covers this share of its box."""

FOLLOWED = 0.5
"""Something is followed when a track is on it in this share of its images, and a track follows
something when it is on it in this share of its own."""

FALSE_APART_PX = 80.0
"""False tracks nearer than this, and within `FALSE_APART_S`, are one event (search radius)."""

FALSE_APART_S = 2.0


@dataclass(frozen=True, eq=False, slots=True)
class Sightings:
    """
    Boxes of some objects in some images, one row each.

    Attributes
    ----------
    step : (n,) int array
        Which image.
    key : (n,) int array
        Which object.
    box : (n, 4) array
        Left, top, width and height, px.

    """

    step: Ints
    key: Ints
    box: Floats

    def and_also(self, other: Sightings) -> Sightings:
        """Return these sightings and others after them."""
        return Sightings(
            np.concatenate([self.step, other.step]),
            np.concatenate([self.key, other.key]),
            np.concatenate([self.box, other.box]),
        )

    def of(self, keys: Ints) -> Sightings:
        """Return the sightings of some objects."""
        kept = np.isin(self.key, keys)
        return Sightings(self.step[kept], self.key[kept], self.box[kept])


@dataclass(frozen=True, slots=True)
class PerceivedEvent:
    """
    One activity with a beginning and an end.

    Attributes
    ----------
    first, last : int
        Its first and last image.
    subjects : tuple of int
        Who truly was in it; empty: the tracker's invention.
    tracks : tuple of int
        Tracks counted to it.
    followed : int
        How many subjects some track followed.

    """

    first: int
    last: int
    subjects: tuple[int, ...]
    tracks: tuple[int, ...]
    followed: int

    @property
    def counted(self) -> int:
        """What the tracker counted: its tracks, or how many it followed if it lost any."""
        lost = self.followed < len(self.subjects)
        return self.followed if lost else len(self.tracks)


def perceived_events(
    truth: Sightings,
    together: Ints,
    tracks: Sightings,
    period_s: float,
    unjudged: Sightings | None = None,
) -> list[PerceivedEvent]:
    """
    Return all events of one class of objects.

    Subjects that touch at some time belong to one event. A track counts to the event of every
    subject that it follows, else to that of the one it is on most; a track that is on nothing in
    half of its images is false.

    Parameters
    ----------
    truth : Sightings
        Subjects, where an operator would see them.
    together : (pairs, 2) int array
        Keys of subjects that touch.
    tracks : Sightings
        Established objects of the tracker.
    period_s : float
        Time between images, s.
    unjudged : Sightings, optional
        Subjects where they are hidden: a track on them is on them, but none need be. Those that
        are nowhere else are no events, and tracks on them are not counted.

    """
    subject, label = _events(truth, together)
    everything = truth if unjudged is None else truth.and_also(unjudged)
    row, of = _on(tracks, everything)
    followed = _followed(truth, of)
    owner = _owners(tracks, everything, row, of)
    events = []
    for event in np.unique(label).tolist():
        members = subject[label == event]
        steps = truth.step[np.isin(truth.key, members)]
        counted = tuple(track for track, keys in owner.items() if np.isin(keys, members).any())
        found = int(np.isin(members, followed).sum())
        span = int(steps.min()), int(steps.max())
        events.append(PerceivedEvent(*span, tuple(members.tolist()), counted, found))
    nothing = np.array([track for track, keys in owner.items() if not len(keys)], np.int64)
    return events + _inventions(tracks.of(nothing), period_s)


def activity_table(events: list[PerceivedEvent]) -> ActivityTable:
    """Return the table of true and counted numbers."""
    return ActivityTable.of([(len(event.subjects), event.counted) for event in events])


def _events(truth: Sightings, together: Ints) -> tuple[Ints, Ints]:
    """Return all subjects and the number of the event that each belongs to."""
    subject = np.unique(truth.key)
    pairs = together.reshape(-1, 2)
    pairs = pairs[np.isin(pairs, subject).all(axis=1)]
    one, other = np.searchsorted(subject, pairs).T
    size = (len(subject), len(subject))
    graph = coo_array((np.ones(len(pairs)), (one, other)), shape=size)
    return subject, np.asarray(connected_components(graph, directed=False)[1], np.int64)


def _on(tracks: Sightings, truth: Sightings) -> tuple[Ints, Ints]:
    """Return which sightings of tracks, and which of subjects, lie on one another."""
    rows, others = [], []
    for step in np.unique(tracks.step).tolist():
        mine, theirs = np.flatnonzero(tracks.step == step), np.flatnonzero(truth.step == step)
        share = shared(tracks.box[mine], truth.box[theirs]) / _area(tracks.box[mine])[:, None]
        one, other = np.nonzero(share >= ON_IT)
        rows.append(mine[one])
        others.append(theirs[other])
    empty = np.empty(0, np.int64)
    return np.concatenate([empty, *rows]), np.concatenate([empty, *others])


def _followed(truth: Sightings, of: Ints) -> Ints:
    """Return the subjects on which some track is in half of their images."""
    covered = np.zeros(len(truth.key), np.bool_)
    covered[of[of < len(truth.key)]] = True
    keys, index, images = np.unique(truth.key, return_inverse=True, return_counts=True)
    return keys[np.bincount(index, covered, len(keys)) >= FOLLOWED * images]


def _owners(tracks: Sightings, truth: Sightings, row: Ints, of: Ints) -> dict[int, Ints]:
    """Return the subjects that each track follows, or is on most; none if it is on nothing."""
    owner: dict[int, Ints] = {}
    images = dict(zip(*(part.tolist() for part in np.unique(truth.key, return_counts=True))))
    for track, seen in zip(*(part.tolist() for part in np.unique(tracks.key, return_counts=True))):
        mine = tracks.key[row] == track
        keys, count = np.unique(truth.key[of[mine]], return_counts=True)
        if len(np.unique(row[mine])) < FOLLOWED * seen:
            owner[track] = keys[:0]
            continue
        follows = [on >= FOLLOWED * images[key] for key, on in zip(keys.tolist(), count)]
        owner[track] = keys[follows if any(follows) else [int(count.argmax())]]
    return owner


def _inventions(tracks: Sightings, period_s: float) -> list[PerceivedEvent]:
    """Return events of tracks on nothing; those near one another in space and time are one."""
    spans = []
    for track in np.unique(tracks.key).tolist():
        own = tracks.key == track
        middle = (tracks.box[own, :2] + tracks.box[own, 2:] / 2).mean(axis=0)
        spans.append((track, tracks.step[own].min(), tracks.step[own].max(), middle))
    near = np.array(
        [
            [
                max(one[1], other[1]) - min(one[2], other[2]) <= FALSE_APART_S / period_s
                and np.linalg.norm(one[3] - other[3]) <= FALSE_APART_PX
                for other in spans
            ]
            for one in spans
        ]
    ).reshape(len(spans), len(spans))
    label = connected_components(coo_array(near), directed=False)[1] if spans else []
    events = []
    for event in np.unique(label).tolist():
        members = [span for span, of in zip(spans, label) if of == event]
        first, last = min(span[1] for span in members), max(span[2] for span in members)
        names = tuple(span[0] for span in members)
        events.append(PerceivedEvent(int(first), int(last), (), names, 0))
    return events


def shared(one: Floats, other: Floats) -> Floats:
    """Return the area that (n, 4) and (m, 4) boxes share, (n, m) px²."""
    low = np.maximum(one[:, None, :2], other[None, :, :2])
    high = np.minimum((one[:, :2] + one[:, 2:])[:, None], (other[:, :2] + other[:, 2:])[None])
    return np.asarray(np.prod(np.maximum(high - low, 0), axis=2))


def _area(box: Floats) -> Floats:
    return np.maximum(box[:, 2] * box[:, 3], 1e-9)
