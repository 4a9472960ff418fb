"""What queries answer: one object a row; times in seconds since the run's first tick."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RunSummary:
    """A run; ``began`` is the date of its first tick, UTC, ISO 8601, or `None` before it."""

    run: str
    site: str
    began: str | None
    seconds: float
    finished: bool


@dataclass(frozen=True, slots=True)
class TrackSummary:
    """A track: when it was there, how far it went and how fast."""

    track_id: int
    class_name: str
    began_s: float
    ended_s: float
    distance_m: float
    mean_mps: float
    top_mps: float


@dataclass(frozen=True, slots=True)
class Place:
    """Where a track was; ``reported_id`` is what it was called at the time."""

    track_id: int
    reported_id: int
    time_s: float
    stamp_ns: int
    x: float
    y: float
    vx: float
    vy: float
    variance_xx: float
    variance_xy: float
    variance_yy: float
    status: str


@dataclass(frozen=True, slots=True)
class Visit:
    """A time of being near, from when to when; the rest is of the closest instant."""

    track_id: int
    began_s: float
    ended_s: float
    closest_m: float
    closest_s: float
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Meeting:
    """Two were near each other, from when to when; the rest is of the closest instant."""

    track_id: int
    other_id: int
    began_s: float
    ended_s: float
    closest_m: float
    closest_s: float
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Event:
    """
    An event; ids are those that are known now, ``reported_id`` is that of the message.

    Of an occupancy or a crowd, ``old_id`` and ``new_id`` are how many were in the zone, and are.
    """

    event: str
    time_s: float
    stamp_ns: int
    track_id: int
    reported_id: int
    old_id: int
    new_id: int
    others: tuple[int, ...]
    probability: float
    x: float | None
    y: float | None
    zone: str


@dataclass(frozen=True, slots=True)
class Crossings:
    """How many crossed a line in a period, to its left and to its right."""

    began_s: float
    to_left: int
    to_right: int


@dataclass(frozen=True, slots=True)
class Occupancy:
    """
    How many were in an area in a period.

    Different ones, on average, most at once, and how many came in and went out.
    """

    began_s: float
    visitors: int
    mean: float
    most: int
    entered: int
    left: int


@dataclass(frozen=True, slots=True)
class Cell:
    """A square of the ground, its middle, and how long somebody was in it, s."""

    x: float
    y: float
    seconds: float


@dataclass(frozen=True, slots=True)
class Showing:
    """A video that shows a track: from when to when, and where in the video, s."""

    camera: str
    path: str
    track_id: int
    began_s: float
    ended_s: float
    video_from_s: float
    video_to_s: float


@dataclass(frozen=True, slots=True)
class Correction:
    """An identity was corrected: whoever was called the old id is the new one, since when."""

    time_s: float
    since_s: float
    old_id: int
    new_id: int
    probability: float


@dataclass(frozen=True, slots=True)
class Group:
    """A time of being together, from when to when; the members by the ids that are known now."""

    group_id: int
    began_s: float
    ended_s: float
    members: tuple[int, ...]
