"""The images of one tick, ready for association."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import INTS_1D, compiled
from mctrack_ros.fusion.joint_tracker.config import JointConfig
from mctrack_ros.fusion.measurements.admission import ROWS, Admitted
from mctrack_ros.interfaces import Detections

Indices = NDArray[np.intp]


class Batch:
    """
    The usable detections of a tick's images, one after the other, as measurements.

    Tracks are at the tick's stamp; a detection measures where its track was a little before (its
    own stamp is earlier), so no track is moved back.

    Parameters
    ----------
    images : sequence of Detections
        One each, in canonical order.
    cameras : sequence of int
        Index of each image's camera in the site's order.
    tick_ns : int
        The tick's stamp, ns.
    config : JointConfig
        Parameters.

    Attributes
    ----------
    detections : Admitted
        Of all images, m rows.
    rows : (m,) structured array
        Of all images, m records.
    image, camera : (m,) int arrays
        Which image, and which camera, each is of.
    stamp_ns : (m,) int64 array
        When it was taken, ns.
    seconds : (images,) array
        From the tick to each image, s; not above 0.
    position : (m, 2) array
        Where the detections are, m.
    noise : (m, 2, 2) array
        Their covariances, m².
    is_described : (m,) bool array
        Who has an appearance template.
    has_templates : bool
        Whether anybody has.
    is_overlapped : (m,) bool array
        Whose box meets that of another single one of its image.
    single : (k,) int array
        Rows of ordinary detections; the others stand for several targets.
    cameras : (images,) int array
        As given.

    """

    def __init__(
        self,
        images: Sequence[Detections],
        cameras: Sequence[int],
        tick_ns: int,
        config: JointConfig,
    ) -> None:
        self.cameras = np.array(cameras, np.intp)
        seconds = [(each.stamp_ns - tick_ns) / 1e9 for each in images]
        known, density = config.motion.sensor_sigma**2, config.motion.acceleration_density
        variance = [known + density * abs(each) ** 3 / 3 for each in seconds]
        self.seconds = np.array(seconds)
        self.detections = Admitted(images, cameras, variance)
        self.rows = rows = self.detections.rows
        self.image, self.camera = rows['image'], rows['camera']
        self.stamp_ns, self.is_described = rows['stamp_ns'], rows['is_described']
        self.position, self.noise = rows['place'], rows['noise']
        is_single, left = rows['is_single'], rows['box'][:, 0]
        self.single = is_single.nonzero()[0]
        self.has_templates = bool(self.is_described.any())
        self.is_overlapped = _overlapped(rows, np.lexsort((left, self.image)))

    @property
    def has_groups(self) -> bool:
        """Tell whether any detection stands for several targets."""
        return len(self.single) < len(self.rows)

    @property
    def groups(self) -> Indices:
        """Return the (k,) rows that do."""
        return np.flatnonzero(~self.rows['is_single'])


@compiled(types.b1[::1](ROWS, INTS_1D))
def _overlapped(rows: Any, order: Indices) -> NDArray[np.bool_]:
    """
    Return which boxes (m,) meet that of another single one of the same image, or are not single.

    The order is by image, then by left edge.
    """
    box, image, is_single = rows['box'], rows['image'], rows['is_single']
    overlaps = np.empty(len(rows), np.bool_)
    for row in range(len(rows)):
        overlaps[row] = not is_single[row]
    for place in range(len(order)):
        row, following = order[place], place + 1
        left, top, width, height = box[row, 0], box[row, 1], box[row, 2], box[row, 3]
        while is_single[row] and following < len(order):
            other, following = order[following], following + 1
            if image[other] != image[row] or not box[other, 0] < left + width:
                break
            if (
                is_single[other]
                and left < box[other, 0] + box[other, 2]
                and top < box[other, 1] + box[other, 3]
                and box[other, 1] < top + height
            ):
                overlaps[row] = overlaps[other] = True
    return overlaps
