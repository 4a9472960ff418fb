"""The pictures of one tick, ready for association."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import INTS_1D, compiled
from mctrack_ros.fusion.admission import usable_rows
from mctrack_ros.fusion.parameters import FusionConfig
from mctrack_ros.fusion.portraits import Portraits
from mctrack_ros.interfaces import Detections
from mctrack_ros.tracking.kalman import position_matrix, symmetric

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


class Looks:
    """
    The usable detections of a tick's pictures, one after the other, as measurements.

    Tracks are at the tick's stamp; a detection measures where its track was a little before (its
    own stamp is earlier), so no track is moved back.

    Parameters
    ----------
    pictures : sequence of Detections
        One each, in canonical order.
    cameras : sequence of int
        Index of each picture's camera in the site's order.
    tick_ns : int
        The tick's stamp, ns.
    config : FusionConfig
        Parameters.
    portraits : Portraits
        What those who are tracked look like.

    Attributes
    ----------
    detections : Detections
        Of all pictures, m rows; their stamp is the tick's.
    picture, camera : (m,) int arrays
        Which picture, and which camera, each is of.
    stamp_ns : (m,) int64 array
        When it was taken, ns.
    seconds : (pictures,) array
        From the tick to each picture, s; not above 0.
    matrix : (pictures, 2, 4) array
        From a track's state at the tick to its position in the picture.
    position : (m, 2) array
        Where the detections are, m.
    noise : (m, 2, 2) array
        Their covariances, m².
    is_overlapped : (m,) bool array
        Whose box meets that of another single one of its picture.
    single, groups : (k,) int arrays
        Rows of ordinary detections, and of those that stand for several targets.
    portraits : Portraits
        As given.

    """

    def __init__(
        self,
        pictures: Sequence[Detections],
        cameras: Sequence[int],
        tick_ns: int,
        config: FusionConfig,
        portraits: Portraits,
    ) -> None:
        self.portraits = portraits
        pictures = [each.select(usable_rows(each)) for each in pictures]
        self.detections = Detections.joined(tick_ns, pictures)
        self.picture = np.repeat(np.arange(len(pictures)), [len(each) for each in pictures])
        self.camera = np.array(cameras, np.intp)[self.picture]
        stamp_ns = np.array([each.stamp_ns for each in pictures], np.int64)
        self.stamp_ns = stamp_ns[self.picture]
        self.seconds = (stamp_ns - tick_ns) / 1e9
        self.matrix = np.ascontiguousarray(position_matrix(self.seconds))
        self.position = self.detections.position[:, :2].astype(np.float64)
        drift = config.motion.acceleration_density * np.abs(self.seconds) ** 3 / 3
        variance = config.motion.sensor_sigma**2 + drift[self.picture]
        covariance = symmetric(self.detections.covariance.astype(np.float64))
        self.noise = covariance + variance[:, None, None] * np.eye(2)
        is_single = self.detections.member_count == 1
        self.single, self.groups = np.flatnonzero(is_single), np.flatnonzero(~is_single)
        self.is_overlapped = ~is_single
        self.is_overlapped[self.single] = overlapped(
            self.detections.box[self.single], self.picture[self.single]
        )


def overlapped(box: NDArray[np.float32], picture: Indices) -> NDArray[np.bool_]:
    """
    Return which (n, 4) boxes (left, top, width, height, px) meet one of the same picture.

    Pictures (n,) ascend.
    """
    return _overlapped(np.ascontiguousarray(box), np.ascontiguousarray(picture))


@compiled(types.b1[::1](types.Array(types.f4, 2, 'C', readonly=True), INTS_1D))
def _overlapped(box: NDArray[np.float32], picture: Indices) -> NDArray[np.bool_]:
    overlaps = np.zeros(len(box), np.bool_)
    first = 0
    while first < len(box):
        last = first + 1
        while last < len(box) and picture[last] == picture[first]:
            last += 1
        order = first + np.argsort(box[first:last, 0])
        for i in range(len(order)):
            one = box[order[i]]
            for other in order[i + 1 :]:
                if not box[other, 0] < one[0] + one[2]:
                    break
                if (
                    one[0] < box[other, 0] + box[other, 2]
                    and one[1] < box[other, 1] + box[other, 3]
                    and box[other, 1] < one[1] + one[3]
                ):
                    overlaps[order[i]] = overlaps[other] = True
        first = last
    return overlaps
