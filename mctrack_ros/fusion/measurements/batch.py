"""The images of one tick, ready for association."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import compiled, inner
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
        self.single: Indices
        self.single, self.is_overlapped, self.has_templates = _surveyed(rows)

    @property
    def has_groups(self) -> bool:
        """Tell whether any detection stands for several targets."""
        return len(self.single) < len(self.rows)

    @property
    def groups(self) -> Indices:
        """Return the (k,) rows that do."""
        return np.flatnonzero(~self.rows['is_single'])


@inner
def _overlapped(
    box: NDArray[np.float32], image: Indices, is_single: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """
    Return which boxes meet that of another single one of the same image, or are not single.

    Parameters
    ----------
    box : (m, 4) float32 array
        Left, top, width, height, px.
    image : (m,) int64 array
        Ascending.
    is_single : (m,) bool array

    """
    overlaps = ~is_single
    first = 0
    while first < len(box):
        last, is_boxed = first + 1, box[first, 2] > 0.0
        while last < len(box) and image[last] == image[first]:
            is_boxed |= box[last, 2] > 0.0
            last += 1
        order = first + np.argsort(box[first:last, 0]) if is_boxed else np.empty(0, np.int64)
        for i in range(len(order)):
            one = box[order[i]]
            for other in order[i + 1 :]:
                if not (is_single[order[i]] and box[other, 0] < one[0] + one[2]):
                    break
                if (
                    is_single[other]
                    and one[0] < box[other, 0] + box[other, 2]
                    and one[1] < box[other, 1] + box[other, 3]
                    and box[other, 1] < one[1] + one[3]
                ):
                    overlaps[order[i]] = overlaps[other] = True
        first = last
    return overlaps


@compiled(types.Tuple([types.i8[::1], types.b1[::1], types.b1])(ROWS))
def _surveyed(rows: Any) -> tuple[Indices, NDArray[np.bool_], bool]:
    """Return the rows (k,) of single ones, who is overlapped (m,), and if any is described."""
    is_single, is_described = rows['is_single'], rows['is_described']
    overlaps = _overlapped(rows['box'], rows['image'], is_single)
    return np.flatnonzero(is_single), overlaps, is_described.any()
