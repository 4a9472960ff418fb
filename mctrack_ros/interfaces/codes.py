"""Numbers that travel in messages and what they stand for; `/site` carries this table."""

from enum import IntEnum, IntFlag

MEMBERS = 16
"""How many global ids a group or an event can name; what is left is zero."""

TEMPLATE_SIZE = 48
"""Bins of an appearance template."""

MAX_CAMERAS = 32
"""Cameras that the bits of one number can tell apart."""


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
    """Tracking events of the event-tracking paper, Table 1, and what the graph adds."""

    NEW = 1
    ENTER = 2
    SPLIT = 3
    EXIT = 4
    MERGE = 5
    STABLE = 6
    CORRECTION = 7
    FEEDBACK_MISSED = 8


class ClassCode(IntEnum):
    """What an object is taken for."""

    UNKNOWN = 0
    PERSON = 1
    VEHICLE = 2
    BICYCLE = 3
    BALL = 4


class FeedbackFlag(IntFlag):
    """What the fusion node tells cameras about a target, event-tracking paper, section 4.3."""

    GROUP_RESOLVED = 1
    ENTERING = 2
    CORRECTED = 4


def code_tables() -> dict[str, dict[str, int]]:
    """Return name -> number of every code, for `/site`."""
    enums = (TrackStatus, EventCode, ClassCode, FeedbackFlag)
    return {
        kind.__name__: {name: int(member) for name, member in kind.__members__.items()}
        for kind in enums
    }
