"""Numbers that travel in messages and what they stand for; `/site` carries this table."""

from enum import IntEnum

MEMBERS = 16
"""How many global ids a group or an event can name; what is left is zero."""

TEMPLATE_SIZE = 48
"""Bins of an appearance template."""

MAX_CAMERAS = 32
"""Number of cameras: one bit each."""


class TrackStatus(IntEnum):
    """Life of a fused track."""

    TENTATIVE = 0
    CONFIRMED = 1
    COASTING = 2
    GROUPED = 3
    DELETED = 4


REPORTED = (TrackStatus.CONFIRMED, TrackStatus.COASTING, TrackStatus.GROUPED)
"""Tracks that the tracker stands for: those that are scored and exported."""


class EventCode(IntEnum):
    """Tracking events of the event-tracking paper, Table 1, and what the graph and zones add."""

    NEW = 1
    ENTER = 2
    SPLIT = 3
    EXIT = 4
    MERGE = 5
    STABLE = 6
    CORRECTION = 7
    FEEDBACK_MISSED = 8
    ENTER_ZONE = 9
    LEAVE_ZONE = 10
    CROSS_LEFT = 11
    CROSS_RIGHT = 12
    DWELL = 13
    OCCUPANCY = 14
    CROWDED = 15


ZONE_EVENTS = (
    EventCode.ENTER_ZONE,
    EventCode.LEAVE_ZONE,
    EventCode.CROSS_LEFT,
    EventCode.CROSS_RIGHT,
    EventCode.DWELL,
    EventCode.OCCUPANCY,
    EventCode.CROWDED,
)
"""Those of the zones and lines of a site."""


class ClassCode(IntEnum):
    """What an object is taken for."""

    UNKNOWN = 0
    PERSON = 1
    VEHICLE = 2
    BICYCLE = 3
    BALL = 4


class Choice(IntEnum):
    """What became of a pair of a track and a detection."""

    BEYOND = 0
    """Too far from where the other images say that the track is."""
    PASSED_OVER = 1
    """Inside the gate, but not each other's best."""
    TAKEN = 2
    """The track took the detection."""
    HIDES = 3
    """The detection is of several, and the track is taken for one of them."""
    BEGINS = 4
    """No track took the detection: it begins this one, alone or with others'."""
    UNUSED = 5
    """No track was near, and none began."""


class Reason(IntEnum):
    """Why a track is as it is after a tick; in brackets what ``value`` and ``limit`` are."""

    COASTS = 0
    """Nothing supports it (since how long, after how long it ends [s])."""
    SEEN = 1
    """It took detections."""
    HIDDEN = 2
    """A detection of several hides it."""
    BEGAN = 3
    """No track explained a detection (log-odds, those that confirm)."""
    CONFIRMED = 4
    """The evidence suffices (log-odds, those that confirm)."""
    RECOGNISED = 6
    """After an encounter it looks like another (difference from that one, from its own past)."""
    ABSORBED = 7
    """Another one turned out to follow the same target."""
    SILENT = 8
    """It ended: nothing supported it (for how long, limit [s])."""
    UNSEEN = 9
    """It ended: the one camera that sees it should see more of it (log-odds, limit)."""
    JOINED = 10
    """It ended: it followed the same target as another one."""
    RESET = 11
    """It ended: time stepped back."""
    REAPPEARED = 12
    """It is new where one who was lost would be by now (-2 log of how much likelier it is him than
    somebody new, largest one)."""


def code_tables() -> dict[str, dict[str, int]]:
    """Return name -> number of every code, for `/site`."""
    enums = (TrackStatus, EventCode, ClassCode, Choice, Reason)
    return {
        kind.__name__: {name: int(member) for name, member in kind.__members__.items()}
        for kind in enums
    }
