"""One period of fusion: what went into it, and the record of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.interfaces.detections import Detections
from mctrack_ros.interfaces.rows import POSITION, Column, Rows, Stamped

R = TypeVar('R', bound=Stamped)


@dataclass(frozen=True, eq=False)
class CameraRows(Generic[R]):
    """
    What a camera says of one image, with its name.

    Attributes
    ----------
    camera : str
        Name in the site's list of cameras.
    rows : Rows
        Stamped with the image's capture time.

    """

    camera: str
    rows: R


CameraDetections = CameraRows[Detections]
"""What a camera detects in one image, with its name."""


@dataclass(frozen=True, eq=False, slots=True)
class Ticks(Rows):
    """
    What was admitted to one tick, one row a camera.

    Where messages of a camera had different times added to their stamps, as its clock was set
    right just then, there is one row more for each time, behind those of all cameras.

    Attributes
    ----------
    position : (n, 3) float32 array
        Not used: NaN.
    camera : (n,) uint32 array
        Index in the site's order.
    admitted : (n,) uint32 array
        Messages admitted to this tick.
    detections : (n,) uint32 array
        Detections, or other rows, in them.
    late : (n,) uint32 array
        Messages that came too late since the last tick, dropped.
    dropped_detections : (n,) uint32 array
        Detections in those.
    feedback_missed : (n,) uint32 array
        Images since the last tick for which the camera lacked its feedback.
    missing : (n,) uint8 array
        1 where a live camera did not report to this tick.
    alive : (n,) uint8 array
        1 where the camera counts as live.
    left_out : (n,) uint32 array
        Messages since the last tick whose stamps could not be believed, dropped.
    added_ms : (n,) int32 array
        What was added to the stamps of those admitted, since the camera's clock differs, ms.
    age_us : (n,) uint32 array
        From the first of those admitted, after that, to the tick, us.

    """

    COLUMNS: ClassVar[dict[str, Column]] = {
        'position': POSITION,
        'camera': Column('u4'),
        'admitted': Column('u4'),
        'detections': Column('u4'),
        'late': Column('u4'),
        'dropped_detections': Column('u4'),
        'feedback_missed': Column('u4'),
        'missing': Column('u1'),
        'alive': Column('u1'),
        'left_out': Column('u4', absent=0),
        'added_ms': Column('i4', absent=0),
        'age_us': Column('u4', absent=0),
    }

    position: NDArray[np.float32]
    camera: NDArray[np.uint32]
    admitted: NDArray[np.uint32]
    detections: NDArray[np.uint32]
    late: NDArray[np.uint32]
    dropped_detections: NDArray[np.uint32]
    feedback_missed: NDArray[np.uint32]
    missing: NDArray[np.uint8]
    alive: NDArray[np.uint8]
    left_out: NDArray[np.uint32]
    added_ms: NDArray[np.int32]
    age_us: NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class RowsTick(Generic[R]):
    """
    Everything that fusion is given for one period, in canonical order.

    Attributes
    ----------
    stamp_ns : int
        The latest stamp admitted; what fusion makes of the tick carries it.
    messages : tuple of CameraRows
        Sorted by camera name, then stamp.
    record : Ticks
        What was admitted, late and missing.

    """

    stamp_ns: int
    messages: tuple[CameraRows[R], ...]
    record: Ticks

    @classmethod
    def of(cls, messages: Iterable[CameraRows[R]]) -> Self:
        """Return a tick of messages, at least one; nothing is recorded of them."""
        ordered = sorted(messages, key=lambda one: (one.camera, one.rows.stamp_ns))
        stamp_ns = max(message.rows.stamp_ns for message in ordered)
        return cls(stamp_ns, tuple(ordered), Ticks.build(stamp_ns))


Tick = RowsTick[Detections]
"""What a tracker of detections is given for one period."""
