"""
What comes to rest becomes background, until it leaves (silhouettes paper, section 5).

As printed, an object rests whose centroid does, and its rectangle is copied. But a driver who
gets out moves the centroid, and leaves a copy of himself in the background. So rest is told by
pixels: those of an object that have looked the same for 4 s are taken, and no others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import parameter
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.background.light import Gains
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.silhouettes.features import Floats
from mctrack_ros.perception.silhouettes.objects import ObjectList
from mctrack_ros.perception.silhouettes.reference_update.absorbed import (
    Inserted,
    uncovered,
    window_of,
)
from mctrack_ros.perception.silhouettes.reference_update.stationarity import Stationarity

Image = NDArray[np.uint8]
CHECKED_S = 0.2  # between checks of what stands still, which takes seconds to count as at rest
ROOM = 0.15  # about what is inserted, in its widths and heights


@dataclass(frozen=True)
class AbsorptionConfig:
    """Parameters of `Absorption`."""

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
    still_share: float = parameter(
        0.5,
        'share of the foreground in an object that has not changed for that time, from which the '
        'object rests; 0: rest is told by the centroid, as printed',
        minimum=0.0,
        maximum=1.0,
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
class _Stop:
    """Where an object has been since when."""

    place: Floats
    since_ns: int


class Absorption:
    """
    Puts what rests into the background and patches the holes that it leaves.

    Parameters
    ----------
    config : AbsorptionConfig
        Parameters.

    Attributes
    ----------
    inserted : list of Inserted
        The recently inserted objects, oldest first.
    still : Stationarity
        For how long the foreground has looked the same.
    looked : bool
        Whether the last image was looked at for that.

    """

    def __init__(self, config: AbsorptionConfig) -> None:
        self._config = config
        self.still = Stationarity(CHECKED_S)
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self.inserted: list[Inserted] = []
        self._rests: dict[int, _Stop] = {}
        self.still.restart()
        self.looked = False

    def watch(self, background: Background, image: Image, mask: Image, stamp_ns: int) -> None:
        """
        Look at an image: what in it is still, and who drives off.

        Parameters
        ----------
        background : Background
            Is changed where inserted objects leave.
        image : (h, w, 3) uint8 array
            The smoothed image.
        mask : (h, w) uint8 array
            Foreground; is changed there, too.
        stamp_ns : int
            Time of the image, ns.

        """
        self.looked = self.still.watch(image, mask, stamp_ns, background.threshold)
        recent_ns = round(self._config.recent_s * 1e9)
        kept = [one for one in self.inserted if stamp_ns - one.stamp_ns <= recent_ns]
        if share := self._config.uncovered_share:
            kept = [one for one in kept if not uncovered(one, background, image, mask, share)]
        self.inserted = kept

    def insert_resting(
        self,
        objects: ObjectList,
        background: Background,
        image: Image,
        mask: Image,
        labels: NDArray[np.uint16],
        stamp_ns: int,
    ) -> NDArray[np.bool_]:
        """
        Insert objects that have come to rest by their rectangles, and patch holes.

        Parameters
        ----------
        objects : ObjectList
            After this image.
        background : Background
            Is changed.
        image : (h, w, 3) uint8 array
            The smoothed image.
        mask : (h, w) uint8 array
            Its foreground.
        labels : (h, w) uint16 array
            Not zero in silhouettes.
        stamp_ns : int
            Its time, ns.

        Returns
        -------
        (n,) bool array
            Objects that are background now.

        """
        if self._config.still_share > 0.0:
            return self._insert_still(objects, background, image, labels, stamp_ns)
        gone = np.zeros(len(objects), np.bool_)
        seconds = self._seconds_at_rest(objects, stamp_ns)
        for row in np.flatnonzero(objects.matched & (objects.group == 0)).tolist():
            hole = self._hole_at(objects.shapes.centroid[row])
            if hole is not None and seconds[row] >= self._config.hole_s:
                self.inserted.remove(hole)
            elif seconds[row] < self._patience(objects, row):
                continue
            gone[row] = True
            box = objects.box[row].astype(np.int64)
            before = _put(image, background, box, ~self._spared(objects, row, box, mask))
            if hole is None:
                shown = mask[window_of(box)].copy()
                self._remember(objects, row, box, before, shown, background.light, stamp_ns)
        return gone

    def _insert_still(
        self,
        objects: ObjectList,
        background: Background,
        image: Image,
        labels: NDArray[np.uint16],
        stamp_ns: int,
    ) -> NDArray[np.bool_]:
        """Insert what has looked the same for long, pixel by pixel; beyond the paper."""
        gone = np.zeros(len(objects), np.bool_)
        if not self.looked:
            return gone
        for row in np.flatnonzero(objects.matched).tolist():
            patience = self._patience(objects, row)
            own = labels[window_of(objects.box[row])] > 0
            same = self.still.still_for(image, window_of(objects.box[row]), patience)
            if np.count_nonzero(own & same) < self._config.still_share * np.count_nonzero(own):
                continue
            gone[row] = True
            box = _widened(objects.box[row], labels.shape)
            taken = self.still.seconds[window_of(box)] >= patience / 2
            taken &= ~self._spared(objects, row, box, labels)
            before = _put(self.still.image, background, box, taken)
            self.still.seconds[window_of(box)][taken] = 0.0
            if objects.class_id[row] == ClassCode.VEHICLE:
                shown = np.where(taken, 255, 0).astype(np.uint8)
                self._remember(objects, row, box, before, shown, background.light, stamp_ns)
        self.still.teach(background, image, self._config.pedestrian_rest_s)
        return gone

    def _remember(
        self,
        objects: ObjectList,
        row: int,
        box: NDArray[np.int64],
        before: Image,
        shown: Image,
        light: Gains,
        stamp_ns: int,
    ) -> None:
        """Add an object to the list of recently inserted ones."""
        place, name = objects.shapes.centroid[row].copy(), int(objects.local_id[row])
        self.inserted.append(Inserted(name, box, place, before, shown, light, stamp_ns))

    def _patience(self, objects: ObjectList, row: int) -> float:
        """Return how long, s, an object must rest."""
        came = objects.travelled_px[row] >= self._config.travel_px
        person = came and objects.class_id[row] == ClassCode.PERSON
        return self._config.pedestrian_rest_s if person else self._config.rest_s

    def _spared(
        self, objects: ObjectList, row: int, box: NDArray[np.int64], mask: NDArray[np.integer]
    ) -> NDArray[np.bool_]:
        """Return where, in a box, the foreground belongs to others."""
        spared = np.zeros((box[3], box[2]), np.bool_)
        if self._config.spare_others:
            for other in np.flatnonzero(objects.matched & (np.arange(len(objects)) != row)):
                low = np.clip(objects.box[other, :2] - box[:2], 0, None).astype(int)
                high = np.clip(
                    objects.box[other, :2] + objects.box[other, 2:] - box[:2], 0, None
                ).astype(int)
                spared[low[1] : high[1], low[0] : high[0]] = True
            spared &= mask[window_of(box)] > 0
        return spared

    def _seconds_at_rest(self, objects: ObjectList, stamp_ns: int) -> Floats:
        """Return for how long, (n,) s, objects have not moved."""
        rests: dict[int, _Stop] = {}
        for key, place in zip(objects.local_id.tolist(), objects.shapes.centroid.copy()):
            rest = self._rests.get(key, _Stop(place, stamp_ns))
            if float(np.hypot(*(place - rest.place))) > self._config.rest_px:
                rest = _Stop(place, stamp_ns)
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


def _put(
    image: NDArray[np.uint8 | np.float32],
    background: Background,
    box: NDArray[np.int64],
    taken: NDArray[np.bool_],
) -> Image:
    """Copy pixels of a rectangle of an image into the background; return what was there."""
    assert background.model is not None
    window = background.model[window_of(box)]
    before = window.copy()
    np.copyto(window, image[window_of(box)], where=taken[..., None], casting='unsafe')
    return before


def _widened(box: Floats, size: tuple[int, ...]) -> NDArray[np.int64]:
    """Return a box with some room about it, in whole pixels, within a (height, width) image."""
    room = np.round(ROOM * box[2:]).astype(np.int64)
    low = np.maximum(box[:2].astype(np.int64) - room, 0)
    high = np.minimum((box[:2] + box[2:]).astype(np.int64) + room, size[::-1])
    return np.concatenate([low, high - low])
