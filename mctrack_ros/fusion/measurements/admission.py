"""Which detections can be used at all."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import Any

import numpy as np
from numba import from_dtype, types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    COLUMN_BYTES,
    COLUMN_IDS,
    COLUMN_SINGLES_2D,
    COLUMN_SINGLES_3D,
    compiled,
    inlined,
    inner,
)
from mctrack_ros.interfaces import LARGEST_DISTANCE, LARGEST_VARIANCE, Detections

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

NO_IMAGE = [Detections.build(0)]
MOST_DETECTIONS = 1000
"""More than this in one image are not detections: those of the highest score are used."""
READ_COLUMNS = attrgetter(
    'position', 'covariance', 'template', 'box', 'extent', 'local_id', 'member_count', 'class_id'
)  # fmt: skip
"""What is read of every image."""
ROW = np.dtype(
    [
        ('place', 'f8', 2),
        ('noise', 'f8', (2, 2)),
        ('stamp_ns', 'i8'),
        ('image', 'i8'),
        ('camera', 'i8'),
        ('box', 'f4', 4),
        ('extent', 'f4', 2),
        ('local_id', 'u4'),
        ('member_count', 'u1'),
        ('class_id', 'u1'),
        ('is_described', '?'),
        ('is_single', '?'),
        ('is_usable', '?'),
    ],
    align=True,
)
ROWS = types.Array(from_dtype(ROW), 1, 'C')
"""Records of what is admitted, for numpy and for numba."""
_READ_TYPES = types.Tuple(
    [COLUMN_SINGLES_2D, COLUMN_SINGLES_3D, types.Array(types.f4, 2, 'C', readonly=True)]
    + [COLUMN_SINGLES_2D] * 2
    + [COLUMN_IDS]
    + [COLUMN_BYTES] * 2
)


def usable_rows(detections: Detections) -> Mask:
    """
    Tell which detections of one image, (n,), have a sound position and covariance.

    A covariance is sound if it is finite, symmetric enough to be positive definite, and not
    larger than a square kilometre. Of a flood only `MOST_DETECTIONS` are used.
    """
    rows, _ = _taken([detections], [len(detections)], [0], [0.0])
    usable = np.ascontiguousarray(rows['is_usable'])
    if len(usable) > MOST_DETECTIONS:
        sound = np.flatnonzero(usable)
        order = np.argsort(-detections.score[sound], kind='stable')
        usable[sound[order[MOST_DETECTIONS:]]] = False
    return usable


def unusable_count(detections: Detections) -> int:
    """Return how many detections of one image cannot be used; a blind message has none."""
    return 0 if detections.is_blind else int((~usable_rows(detections)).sum())


class Admitted:
    """
    The usable detections of several images, one after the other, m rows.

    What is always used of them is put together as records at once; columns of `Detections` that
    are not among these when they are first asked for.

    Parameters
    ----------
    images : sequence of Detections
        One each.
    cameras : sequence of int
        Whose each image is.
    variance : sequence of float
        What is added to the variances of each image, m².

    Attributes
    ----------
    rows : (m,) structured array
        What each says: a `ROW`.

    """

    def __init__(
        self, images: Sequence[Detections], cameras: Sequence[int], variance: Sequence[float]
    ) -> None:
        self._images = images
        counts = list(map(len, images))
        if max(counts, default=0) > MOST_DETECTIONS:
            self._images = images = list(map(_without_flood, images))
            counts = list(map(len, images))
        self.rows, usable = _taken(images, counts, cameras, variance)
        self._usable: Mask | None = None
        if usable < len(self):
            self._usable = self.rows['is_usable']
            self.rows = self.rows[self._usable]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.rows)

    def __getattr__(self, name: str) -> NDArray[Any]:
        """Return a column of the records, or put one together and keep it."""
        if name in (ROW.names or ()):
            return self.rows[name]
        if name not in Detections.COLUMNS:
            raise AttributeError(name)
        column = np.concatenate([getattr(each, name) for each in self._images or NO_IMAGE])
        column = column if self._usable is None else column[self._usable]
        self.__dict__[name] = column
        return column


def _without_flood(image: Detections) -> Detections:
    if len(image) <= MOST_DETECTIONS:
        return image
    return image.select(usable_rows(image))


def _taken(
    images: Sequence[Detections],
    counts: Sequence[int],
    cameras: Sequence[int],
    variance: Sequence[float],
) -> tuple[NDArray[Any], int]:
    """Return the records of some images, and how many of them can be used."""
    rows, usable, first = np.empty(sum(counts), ROW), 0, 0
    for image, (each, count, camera, more) in enumerate(zip(images, counts, cameras, variance)):
        usable += _take(READ_COLUMNS(each), each.stamp_ns, image, camera, more, rows, first)
        first += count
    return rows, usable


@inlined
def _is_sound(place: Floats, noise: Floats) -> bool:
    """Tell whether a place and its covariance can be."""
    xx, xy, yy = noise[0, 0], noise[0, 1], noise[1, 1]
    sound = xx > 0 and yy > 0 and xx * yy > xy * xy
    sound = sound and xx < LARGEST_VARIANCE and yy < LARGEST_VARIANCE
    return bool(sound and abs(place[0]) < LARGEST_DISTANCE and abs(place[1]) < LARGEST_DISTANCE)


@inner
def _is_filled(template: NDArray[np.float32], row: int) -> bool:
    filled = 0
    for bin in range(template.shape[1]):
        filled += template[row, bin] != 0.0
    return filled > 0


@compiled(types.i8(_READ_TYPES, types.i8, types.i8, types.i8, types.f8, ROWS, types.i8))
def _take(
    reported: tuple[Any, ...], stamp_ns: int, image: int, camera: int, variance: float,
    all_rows: Any, first: int,
) -> int:  # fmt: skip
    """Write what one image tells into records, from one on; return how many can be used."""
    position, covariance, template, box, extent, local_id, member_count, kind = reported
    rows = all_rows[first : first + len(position)]
    to_place, to_noise = rows['place'], rows['noise']
    to_box, to_extent, usable = rows['box'], rows['extent'], 0
    for row in range(len(rows)):
        own = rows[row]
        for i in range(2):
            to_place[row, i], to_extent[row, i] = position[row, i], extent[row, i]
            for j in range(2):
                both = np.float64(covariance[row, i, j]) + np.float64(covariance[row, j, i])
                to_noise[row, i, j] = both / 2
        own['is_usable'] = _is_sound(to_place[row], to_noise[row])
        usable += own['is_usable']
        for i in range(2):
            to_noise[row, i, i] += variance
        for i in range(4):
            to_box[row, i] = box[row, i]
        own['stamp_ns'], own['image'], own['camera'] = stamp_ns, image, camera
        own['is_described'], own['is_single'] = _is_filled(template, row), member_count[row] == 1
        own['local_id'], own['class_id'] = local_id[row], kind[row]
        own['member_count'] = member_count[row]
    return usable
