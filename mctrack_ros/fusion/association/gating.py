"""Which pairs of a track and a detection are worth a thought: the gate, at any scale."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import (
    COLUMN_2D,
    COLUMN_3D,
    FLOATS_1D,
    FLOATS_2D,
    FLOATS_3D,
    INTS_1D,
    compiled,
    inner,
)
from mctrack_ros.fusion.association.solvers.pairs import counted
from mctrack_ros.fusion.measurements.packed import XX, XY, YY, X, Y
from mctrack_ros.fusion.neighbours import cell_slot, grown

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

USUAL = 4.0
"""A detection up to so many times less certain (variance) than the median is found by its cell;
any other is tried with every track."""
NOTHING = -1


@inner
def seen_at(
    mean: Floats, covariance: Floats, track: int, seconds: float
) -> tuple[float, float, float, float, float]:
    """Return where a track is so much later, x, y, and how surely: xx, xy, yy."""
    square = seconds**2
    mixed = covariance[track, 0, 3] + covariance[track, 2, 1]
    return (
        mean[track, 0] + seconds * mean[track, 2],
        mean[track, 1] + seconds * mean[track, 3],
        covariance[track, 0, 0]
        + seconds * (covariance[track, 0, 2] + covariance[track, 2, 0])
        + square * covariance[track, 2, 2],
        covariance[track, 0, 1] + seconds * mixed + square * covariance[track, 2, 3],
        covariance[track, 1, 1]
        + seconds * (covariance[track, 1, 3] + covariance[track, 3, 1])
        + square * covariance[track, 3, 3],
    )


@inner
def distance(x: float, y: float, xx: float, xy: float, yy: float) -> tuple[float, float]:
    """Return the squared length of an offset under a covariance, and that one's determinant."""
    determinant = xx * yy - xy * xy
    return (yy * x * x - 2 * xy * x * y + xx * y * y) / determinant, determinant


@compiled(types.f8[:, ::1](COLUMN_2D, COLUMN_3D, FLOATS_1D, FLOATS_2D, FLOATS_3D))
def distances(
    mean: Floats, covariance: Floats, seconds: Floats, position: Floats, noise: Floats
) -> Floats:
    """Return the (m, n) squared Mahalanobis distances of measurements, each so much later (m,)."""
    squared = np.empty((len(position), len(mean)))
    for row in range(len(position)):
        for track in range(len(mean)):
            x, y, xx, xy, yy = seen_at(mean, covariance, track, seconds[row])
            squared[row, track] = distance(
                position[row, 0] - x,
                position[row, 1] - y,
                xx + noise[row, 0, 0],
                xy + noise[row, 0, 1],
                yy + noise[row, 1, 1],
            )[0]
    return squared


@inner
def _largest(xx: float, xy: float, yy: float) -> float:
    """Return the larger eigenvalue of a symmetric (2, 2) matrix."""
    half = (xx - yy) / 2
    return float((xx + yy) / 2 + np.sqrt(half * half + xy * xy))


@inner
def _grid(
    seen: Floats, variance: Floats, usual: float, edge: float
) -> tuple[Indices, Indices, Indices]:
    """
    Sort detections into the hashed cells of a grid, of an edge in m.

    Returns
    -------
    first : (buckets + 1,) array
        The first detection of each bucket, `NOTHING` if it has none; the last bucket holds the
        unusually uncertain ones.
    following : (m,) array
        The next detection of the same bucket.
    cell : (m, 2) array
        Which cell each is in: cells may share a bucket.

    """
    count, buckets = len(seen), 1
    while buckets < count:
        buckets *= 2
    first, following = np.full(buckets + 1, NOTHING), np.empty(count, np.int64)
    cell = np.empty((count, 2), np.int64)
    for row in range(count - 1, -1, -1):
        for axis, column in enumerate((X, Y)):
            cell[row, axis] = int(np.floor(seen[row, column] / edge))
        bucket = cell_slot(cell[row, 0], cell[row, 1], buckets)
        if variance[row] > usual:
            bucket = buckets
        following[row], first[bucket] = first[bucket], row
    return first, following, cell


@inner
def _reached(
    x: float, y: float, reach: float, edge: float,
    first: Indices, following: Indices, cell: Indices, near: Indices,
) -> int:  # fmt: skip
    """Write the detections of all cells that a square reaches; return their number."""
    left, right = np.floor((x - reach) / edge), np.floor((x + reach) / edge)
    low, high = np.floor((y - reach) / edge), np.floor((y + reach) / edge)
    if (right - left + 1) * (high - low + 1) > len(near):
        for row in range(len(near)):
            near[row] = row
        return len(near)
    buckets = len(first) - 1
    count, row = 0, first[buckets]
    while row != NOTHING:
        near[count], row, count = row, following[row], count + 1
    for i in range(int(left), int(right) + 1):
        for j in range(int(low), int(high) + 1):
            row = first[cell_slot(i, j, buckets)]
            while row != NOTHING:
                if cell[row, 0] == i and cell[row, 1] == j:
                    near[count], count = row, count + 1
                row = following[row]
    return count


@inner
def _sort(values: Indices) -> None:
    """Sort in place what is mostly a few values, by Shell's method."""
    gap = 1
    while gap < len(values) // 3:
        gap = 3 * gap + 1
    while gap > 0:
        for index in range(gap, len(values)):
            value, before = values[index], index - gap
            while before >= 0 and values[before] > value:
                values[before + gap] = values[before]
                before -= gap
            values[before + gap] = value
        gap //= 3


@compiled(types.i8[::1](INTS_1D, INTS_1D))
def slots(image: Indices, track: Indices) -> Indices:
    """Give each track in each image a number; pairs (k,) are sorted by image, then track."""
    slot, number = np.empty(len(track), np.int64), -1
    for pair in range(len(track)):
        if pair == 0 or image[pair] != image[pair - 1] or track[pair] != track[pair - 1]:
            number += 1
        slot[pair] = number
    return slot


def gated_pairs(
    mean: Floats, covariance: Floats, seconds: Floats, seen: Floats, image: Indices, gate: float
) -> Indices:
    """
    Find the pairs whose squared Mahalanobis distance is below the gate.

    Detections are sorted into square cells on the ground, so that a track is compared with those
    near by alone.

    Parameters
    ----------
    mean : (n, 4) array
        Predicted x, y, vx, vy of the tracks; m and m/s.
    covariance : (n, 4, 4) array
        Their covariances.
    seconds : (images,) array
        From the tracks' stamp to each image's, s.
    seen : (m, 8) array
        What the detections say, see `measured`.
    image : (m,) int64 array
        Which image each is of; ascending.
    gate : float
        Largest squared distance.

    Returns
    -------
    (4, k) int64 array
        Track, detection, image and slot of each pair, see `Pairs`; sorted by image, track and
        detection.

    """
    if not len(seen) or not len(mean):
        return np.empty((4, 0), np.int64)
    variance = _variances(seen)
    middle = len(seen) // 2
    usual = USUAL * float(np.partition(variance, middle)[middle])
    return _in_gate(mean, covariance, seconds, seen, image, gate, variance, usual)


@compiled(types.f8[::1](FLOATS_2D))
def _variances(seen: Floats) -> Floats:
    """Return the largest variance, (m,), of each detection in any direction, m²."""
    variance = np.empty(len(seen))
    for row in range(len(seen)):
        variance[row] = _largest(seen[row, XX], seen[row, XY], seen[row, YY])
    return variance


@compiled(
    types.i8[:, ::1](
        COLUMN_2D,
        COLUMN_3D,
        FLOATS_1D,
        FLOATS_2D,
        INTS_1D,
        types.f8,
        FLOATS_1D,
        types.f8,
    )
)
def _in_gate(
    mean: Floats, covariance: Floats, seconds: Floats, seen: Floats, image: Indices, gate: float,
    variances: Floats, usual: float,
) -> Indices:  # fmt: skip
    """
    Return the pairs in the gate as `gated_pairs` does.

    Detections with a variance above the `usual` are tried with every track.

    """
    longest = 0.0
    for index in range(len(seconds)):
        longest = max(longest, abs(seconds[index]))
    edge = np.sqrt(gate * usual)
    first, following, cell = _grid(seen, variances, usual, edge)
    near = np.empty(len(seen), np.int64)
    tracks, detections = np.empty(len(near), np.int64), np.empty(len(near), np.int64)
    found = 0
    for track in range(len(mean)):
        variance = _largest(
            covariance[track, 0, 0], covariance[track, 0, 1], covariance[track, 1, 1]
        )
        reach = np.sqrt(gate * (variance + usual))
        reach += np.hypot(mean[track, 2], mean[track, 3]) * longest
        count = _reached(mean[track, 0], mean[track, 1], reach, edge, first, following, cell, near)
        if found + count > len(tracks):
            tracks = grown(tracks, 2 * (found + count))
            detections = grown(detections, len(tracks))
        begin, later = found, np.nan
        for index in range(count):
            row = near[index]
            if seconds[image[row]] != later:
                later = seconds[image[row]]
                x, y, xx, xy, yy = seen_at(mean, covariance, track, later)
            squared, _ = distance(
                seen[row, X] - x,
                seen[row, Y] - y,
                xx + seen[row, XX],
                xy + seen[row, XY],
                yy + seen[row, YY],
            )
            if squared < gate:
                tracks[found], detections[found], found = track, row, found + 1
        _sort(detections[begin:found])
    key, pairs = np.empty(found, np.int64), np.empty((4, found), np.int64)
    for index in range(found):
        key[index] = image[detections[index]]
    order = counted(key, image[len(image) - 1] + 1)
    for pair in range(found):
        row = detections[order[pair]]
        pairs[0, pair], pairs[1, pair], pairs[2, pair] = tracks[order[pair]], row, image[row]
    pairs[3] = slots(pairs[2], pairs[0])
    return pairs
