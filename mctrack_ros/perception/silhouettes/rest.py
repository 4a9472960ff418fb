"""What comes to rest becomes background, until it leaves (silhouettes paper, section 5)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.silhouettes.background import LowPassBackground
from mctrack_ros.perception.silhouettes.features import Floats
from mctrack_ros.perception.silhouettes.objects import ObjectList

Grey = NDArray[np.uint8]


@dataclass(frozen=True)
class RestConfig:
    """Parameters of `RestWatch`."""

    rest_s: float = parameter(
        4.0, 'time at rest after which a vehicle becomes background [s]', minimum=0.0
    )
    pedestrian_rest_s: float = parameter(
        12.0,
        'the same for pedestrians who came from elsewhere; as printed: the same [s]',
        minimum=0.0,
    )
    rest_px: float = parameter(
        3.0, 'distance that the centroid of what rests may move [px]', minimum=0.0
    )
    travel_px: float = parameter(
        20.0,
        'distance that a pedestrian has come at some time; what has not is no pedestrian [px]',
        minimum=0.0,
    )
    recent_s: float = parameter(
        3600.0, 'time that inserted objects are remembered [s]', minimum=0.0
    )
    hole_s: float = parameter(
        0.5, 'time at rest after which the hole of an inserted object is patched [s]', minimum=0.0
    )
    hole_px: float = parameter(
        0.0, 'distance of a hole from the object that left it [px]', minimum=0.0
    )
    spare_others: bool = parameter(
        True, 'other objects in the rectangle stay foreground; false: as printed'
    )
    uncovered_share: float = parameter(
        0.3,
        'share of an inserted object behind which the old background has come back, from which it '
        'is taken out again; 0: never, as printed',
        minimum=0.0,
        maximum=1.0,
    )


@dataclass(frozen=True, eq=False, slots=True)
class Inserted:
    """
    An entry of the list of recently inserted objects.

    Attributes
    ----------
    local_id : int
        What it was called.
    box : (4,) int array
        Its rectangle, px.
    centroid : (2,) float array
        Its centroid, px.
    before : (h, w) uint8 array
        The background that it hides.
    mask : (h, w) uint8 array
        255 where it was foreground.
    light : float
        The background's brightness at that time.
    stamp_ns : int
        When it was inserted.

    """

    local_id: int
    box: NDArray[np.int64]
    centroid: Floats
    before: Grey
    mask: Grey
    light: float
    stamp_ns: int


@dataclass(frozen=True, eq=False, slots=True)
class _Rest:
    """Where an object has been since when."""

    place: Floats
    since_ns: int


class RestWatch:
    """
    Puts what rests into the background and patches the holes that it leaves.

    Parameters
    ----------
    config : RestConfig
        Parameters.

    Attributes
    ----------
    inserted : list of Inserted
        The recently inserted objects, oldest first.

    """

    def __init__(self, config: RestConfig) -> None:
        self._config = config
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self.inserted: list[Inserted] = []
        self._rests: dict[int, _Rest] = {}

    def uncover(
        self, background: LowPassBackground, grey: Grey, mask: Grey, stamp_ns: int
    ) -> None:
        """
        Take objects that drive off out of the background again; beyond the paper.

        Where the picture shows again what an inserted object had hidden, the object is leaving:
        at once there is neither a hole nor a vehicle that is half background.

        Parameters
        ----------
        background : LowPassBackground
            Is changed.
        grey : (h, w) uint8 array
            The smoothed picture.
        mask : (h, w) uint8 array
            Foreground; is changed.
        stamp_ns : int
            Time of the picture, ns.

        """
        recent_ns = round(self._config.recent_s * 1e9)
        self.inserted = [one for one in self.inserted if stamp_ns - one.stamp_ns <= recent_ns]
        if self._config.uncovered_share == 0.0:
            return
        for entry in list(self.inserted):
            left, top, width, height = entry.box.tolist()
            window = np.s_[top : top + height, left : left + width]
            seen = cv2.bitwise_and(mask[window], entry.mask)
            changed = cv2.countNonZero(seen)
            if changed < self._config.uncovered_share * cv2.countNonZero(entry.mask):
                continue
            gain = background.light / entry.light
            before = np.asarray(cv2.convertScaleAbs(entry.before, alpha=gain), np.uint8)
            differs = cv2.absdiff(grey[window], before) > background.threshold
            back = (seen > 0) & ~differs
            if back.sum() >= self._config.uncovered_share * cv2.countNonZero(entry.mask):
                background.restore(before, entry.box, entry.mask)
                mask[window][entry.mask > 0] = 255 * differs[entry.mask > 0]
                self.inserted.remove(entry)

    def insert_resting(
        self,
        objects: ObjectList,
        background: LowPassBackground,
        grey: Grey,
        mask: Grey,
        stamp_ns: int,
    ) -> NDArray[np.bool_]:
        """
        Insert objects that have come to rest by their rectangles, and patch holes.

        Parameters
        ----------
        objects : ObjectList
            After this picture.
        background : LowPassBackground
            Is changed.
        grey : (h, w) uint8 array
            The smoothed picture.
        mask : (h, w) uint8 array
            Its foreground.
        stamp_ns : int
            Its time, ns.

        Returns
        -------
        (n,) bool array
            Objects that are background now.

        """
        gone = np.zeros(len(objects), np.bool_)
        seconds = self._seconds_at_rest(objects, stamp_ns)
        for row in np.flatnonzero(objects.matched & (objects.group == 0)).tolist():
            hole = self._hole_at(objects.shapes.centroid[row])
            came = objects.travelled_px[row] >= self._config.travel_px
            person = came and objects.class_id[row] == ClassCode.PERSON
            patience = self._config.pedestrian_rest_s if person else self._config.rest_s
            if hole is not None and seconds[row] >= self._config.hole_s:
                self.inserted.remove(hole)
            elif seconds[row] < patience:
                continue
            gone[row] = True
            box = objects.box[row].astype(np.int64)
            before = background.insert(grey, box, self._spared(objects, row, box, mask))
            if hole is None:
                left, top, width, height = box.tolist()
                shown = mask[top : top + height, left : left + width].copy()
                place, name = objects.shapes.centroid[row].copy(), int(objects.local_id[row])
                light = background.light
                self.inserted.append(Inserted(name, box, place, before, shown, light, stamp_ns))
        return gone

    def _spared(
        self, objects: ObjectList, row: int, box: NDArray[np.int64], mask: Grey
    ) -> NDArray[np.bool_]:
        """Return where, in a box, the foreground belongs to others."""
        left, top, width, height = box.tolist()
        spared = np.zeros((height, width), np.bool_)
        if self._config.spare_others:
            for other in np.flatnonzero(objects.matched & (np.arange(len(objects)) != row)):
                low = np.clip(objects.box[other, :2] - box[:2], 0, None).astype(int)
                high = np.clip(
                    objects.box[other, :2] + objects.box[other, 2:] - box[:2], 0, None
                ).astype(int)
                spared[low[1] : high[1], low[0] : high[0]] = True
            spared &= mask[top : top + height, left : left + width] > 0
        return spared

    def _seconds_at_rest(self, objects: ObjectList, stamp_ns: int) -> Floats:
        """Return for how long, (n,) s, objects have not moved."""
        rests: dict[int, _Rest] = {}
        for key, place in zip(objects.local_id.tolist(), objects.shapes.centroid.copy()):
            rest = self._rests.get(key, _Rest(place, stamp_ns))
            if float(np.hypot(*(place - rest.place))) > self._config.rest_px:
                rest = _Rest(place, stamp_ns)
            rests[key] = rest
        self._rests = rests
        return np.array([(stamp_ns - rest.since_ns) * 1e-9 for rest in rests.values()])

    def _hole_at(self, centroid: Floats) -> Inserted | None:
        """Return the inserted object nearest to a centroid, if it is near enough."""
        near = [
            (float(np.hypot(*(centroid - entry.centroid))), index)
            for index, entry in enumerate(self.inserted)
        ]
        distance, index = min(near, default=(np.inf, -1))
        return self.inserted[index] if distance <= self._config.hole_px else None
