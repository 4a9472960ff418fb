"""Detections of another detector in the images of one camera, not yet on the ground."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.recording.tables.columns import TableError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
_DAY_NS = 86_400_000_000_000
_MOST_IMAGES = 10_000_000
_GAP = 1.5
"""Gap, in intervals, from which images are missing."""


@dataclass(frozen=True, eq=False, slots=True)
class Sightings:
    """
    Boxes, or places on the ground, image by image.

    Attributes
    ----------
    stamp_ns : (p,) int64 array
        When the images were taken, ascending: all that are known of, also those without rows.
    image : (n,) int64 array
        Which of them each row is of, ascending.
    box : (n, 4) float64 array
        Left, top, width, height, px; NaN where there is none.
    position : (n, 2) float64 array
        On the ground, m; NaN where there is none.
    sigma : (n,) float64 array
        Standard deviation of the position along each axis, m; NaN where unknown.
    score : (n,) float64 array
        Confidence, 0 to 1.
    label : (n,) str array
        Class, as the detector calls it; empty where it names none.
    local_id : (n,) int64 array
        The detector's own tracks, from 1; 0: none.
    interval_ns : float
        Time between images, ns; 0: all are known of.
    unused : tuple of str
        Headings of columns that were not read.
    """

    stamp_ns: Ints
    image: Ints
    box: Floats
    position: Floats
    sigma: Floats
    score: Floats
    label: NDArray[np.str_]
    local_id: Ints
    interval_ns: float = 0.0
    unused: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.image)


def numbered(names: list[str]) -> Ints:
    """Return numbers from 1 for names, (n,), in the order of their first use; 0 for empty ones."""
    numbers: dict[str, int] = {'': 0}
    return np.array([numbers.setdefault(name, len(numbers)) for name in names], np.int64)


def check_count(images: int, where: str) -> None:
    """Raise `TableError` if there are so many images that a frame or time must be wrong."""
    if images > _MOST_IMAGES:
        raise TableError(f'{where}: {images} images: is a frame or a time wrong?')


def with_all_images(sightings: Mapping[str, Sightings]) -> dict[str, Sightings]:
    """
    Add the images in which nothing was seen: a camera that says nothing seems to be lost.

    Parameters
    ----------
    sightings : mapping of str to Sightings
        By camera. All are taken to see from when the first saw something till the last does.

    """
    ranges = sorted((int(each.stamp_ns[0]), name) for name, each in sightings.items())
    if ranges[-1][0] - ranges[0][0] > _DAY_NS:
        raise TableError(
            f'the times of {ranges[-1][1]} begin {(ranges[-1][0] - ranges[0][0]) / 1e9:.0f} s '
            f'after those of {ranges[0][1]}: all cameras need one clock'
        )
    begin = min(int(each.stamp_ns[0]) for each in sightings.values())
    end = max(int(each.stamp_ns[-1]) for each in sightings.values())
    return {name: _completed(name, each, begin, end) for name, each in sightings.items()}


def _completed(name: str, sightings: Sightings, begin_ns: int, end_ns: int) -> Sightings:
    interval, stamps = sightings.interval_ns, sightings.stamp_ns
    if not interval:
        return sightings
    check_count(int((end_ns - begin_ns) / interval), name)
    before = np.arange(round((int(stamps[0]) - begin_ns) / interval), 0, -1)
    after = np.arange(1, round((end_ns - int(stamps[-1])) / interval) + 1)
    added = [stamps, stamps[0] - _whole(before * interval), stamps[-1] + _whole(after * interval)]
    for index in np.flatnonzero(np.diff(stamps) > _GAP * interval):
        gap = int(stamps[index + 1] - stamps[index])
        count = round(gap / interval)
        added.append(stamps[index] + _whole(np.arange(1, count) * (gap / count)))
    everything = np.sort(np.concatenate(added))
    where = np.searchsorted(everything, stamps)
    return replace(sightings, stamp_ns=everything, image=where[sightings.image])


def _whole(nanoseconds: NDArray[np.floating[Any]]) -> Ints:
    whole: Ints = np.rint(nanoseconds).astype(np.int64)
    return whole
