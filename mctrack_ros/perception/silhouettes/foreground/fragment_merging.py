"""Before step 1, beyond the paper: fragments that fit one body at that spot are one silhouette."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_1D, FLOATS_2D, FLOATS_3D, INTS_1D, compiled, inner
from mctrack_ros.config import parameter
from mctrack_ros.perception.geometry.person_size import SizeTable, metre_at
from mctrack_ros.perception.silhouettes.features import (
    HEIGHT,
    WIDTH,
    Floats,
    Ints,
    Shapes,
    stacked,
)
from mctrack_ros.perception.silhouettes.foreground.components import Silhouettes

SLACK = 0.2  # by how much an object may be larger than it is known to be


@dataclass(frozen=True)
class FragmentMergingConfig:
    """Parameters of `gathered`."""

    person_height_m: float = parameter(
        1.95, 'tallest person that fragments make up; 0: none are joined, as printed [m]',
        minimum=0.0,
    )  # fmt: skip
    person_width_m: float = parameter(1.0, 'widest such person [m]', minimum=0.0)
    vehicle_height_m: float = parameter(
        2.6, 'tallest vehicle that fragments make up, roof and depth together [m]', minimum=0.0
    )
    vehicle_width_m: float = parameter(5.0, 'widest such vehicle [m]', minimum=0.0)
    vehicle_part_m: float = parameter(
        1.3, 'width from which a fragment may be part of a vehicle [m]', minimum=0.0
    )
    vehicle_gap_m: float = parameter(
        0.8, 'greatest gap between parts of a vehicle [m]', minimum=0.0
    )

    group_width_m: float = parameter(
        2.2, 'widest group of people who came together [m]', minimum=0.0
    )
    group_gap_m: float = parameter(
        0.6, 'greatest gap between people who came together [m]', minimum=0.0
    )
    least_part_m: float = parameter(
        0.25,
        'side of the smallest square that somebody shows of himself, a head; what is smaller is '
        'nobody; 0: whatever there is, as printed [m]',
        minimum=0.0,
    )
    faint_sigmas: float = parameter(
        5.6,
        'standard deviations of the noise by which what is faint between the fragments of a small '
        'body differs; 0: it does not count, as printed',
        minimum=0.0,
    )  # 3 in grey images, whose noise the background, which expects three channels, halves
    known_s: float = parameter(
        1.0, 'time after which an object that was seen whole and alone is known [s]', minimum=0.0
    )

    def limits(self) -> Floats:
        """Return the first eight as an array."""
        return np.array(
            [
                self.person_width_m, self.person_height_m, self.vehicle_width_m,
                self.vehicle_height_m, self.vehicle_part_m, self.vehicle_gap_m,
                self.group_width_m, self.group_gap_m,
            ]
        )  # fmt: skip


def gathered(
    silhouettes: Silhouettes, known: Shapes, sizes: SizeTable, config: FragmentMergingConfig
) -> Silhouettes:
    """
    Join fragments, the closest first, while the union is no larger than one body or one group.

    Low contrast leaves a head, a belt and two shoes of a pedestrian. The paper's steps 6 and 7
    find them together again only if the object was whole before, and it may never be: it enters
    in pieces. How tall a person looks where is known from the camera's calibration.

    Fragments where one known object is expected join if the union is no larger than that; those
    of different ones never do. People side by side whom no known object claims came together, and
    are one object (assumption 3 of section 3).

    Parameters
    ----------
    silhouettes : Silhouettes
        Of an image.
    known : Shapes
        Objects that have been tracked for a while, where they are expected.
    sizes : SizeTable
        Of the camera.
    config : FragmentMergingConfig
        Parameters.

    Returns
    -------
    Silhouettes
        With fewer rows, in the order of their first fragments.

    """
    shapes = silhouettes.shapes
    if config.person_height_m == 0.0 or len(shapes) < 2:
        return silhouettes
    expected = _expected(known)
    claim = _claims(shapes, expected)
    group = _group(shapes.box, claim, expected, sizes.table, config.limits())
    names, row = np.unique(group, return_inverse=True)
    if len(names) == len(shapes):
        return silhouettes
    united = stacked(*(shapes.select(np.flatnonzero(group == name)).united() for name in names))
    row_of = np.r_[-1, row].astype(np.int64)[silhouettes.row_of + 1]
    return Silhouettes(united, silhouettes.labels, row_of, silhouettes.grey)


def without_crumbs(
    silhouettes: Silhouettes, sizes: SizeTable, config: FragmentMergingConfig
) -> Silhouettes:
    """
    Leave out what is too small to be seen of anybody there; beyond the paper.

    What somebody leaves behind in the background, or shows of himself beside a car, would take
    his place and size while he walks on.

    Parameters
    ----------
    silhouettes : Silhouettes
        Of an image, gathered.
    sizes : SizeTable
        Of the camera.
    config : FragmentMergingConfig
        Parameters.

    """
    shapes = silhouettes.shapes
    if config.least_part_m == 0.0 or not len(shapes):
        return silhouettes
    head = (config.least_part_m * sizes.per_metre(sizes.foot_of(shapes.box))).prod(axis=1)
    crumbs = np.flatnonzero(shapes.area < head).tolist()
    return silhouettes.without(crumbs) if crumbs else silhouettes


def _expected(known: Shapes) -> Floats:
    """Return boxes, (n, 4) px, of the size that objects are known to have."""
    size = np.maximum(known.box[:, 2:], known.vector[:, [WIDTH, HEIGHT]]) * (1 + SLACK)
    middle = known.box[:, :2] + known.box[:, 2:] / 2
    return np.column_stack([middle - size / 2, size])


def _claims(shapes: Shapes, expected: Floats) -> Ints:
    """Return for each silhouette the object in whose expected box its middle is; -1: none."""
    middle = shapes.box[:, :2] + shapes.box[:, 2:] / 2
    apart = np.abs(middle[:, None] - (expected[:, :2] + expected[:, 2:] / 2)[None])
    share = (apart / np.maximum(expected[:, 2:] / 2, 1.0)[None]).max(axis=2, initial=0.0)
    if not share.size:
        return np.full(len(shapes), -1)
    return np.where(share.min(axis=1) <= 1.0, share.argmin(axis=1), -1)


@inner
def _united(one: Floats, other: Floats) -> NDArray[np.float64]:
    left, top = min(one[0], other[0]), min(one[1], other[1])
    right = max(one[0] + one[2], other[0] + other[2])
    bottom = max(one[1] + one[3], other[1] + other[3])
    return np.array([left, top, right - left, bottom - top])


@inner
def _gap(one: Floats, other: Floats, claimed: bool, sizes: Floats, limits: Floats) -> float:
    """Return the gap, m, between two boxes that may be one body; else infinity."""
    both = _united(one, other)
    across, upright, _, _ = metre_at(sizes, both[0] + both[2] / 2, both[1] + both[3])
    if not (across > 0.0 and upright > 0.0):
        return np.inf
    width, height = both[2] / across, both[3] / upright
    gap_x = max(one[0], other[0]) - min(one[0] + one[2], other[0] + other[2])
    gap_y = max(one[1], other[1]) - min(one[1] + one[3], other[1] + other[3])
    gap = max(max(gap_x / across, gap_y / upright), 0.0)
    if width <= limits[0] and height <= limits[1]:
        return float(gap)
    together = max(one[2], other[2]) / across < limits[4] and not claimed
    if together and width <= limits[6] and height <= 1.2 * limits[1] and gap <= limits[7]:
        return float(gap)
    part = min(one[2], other[2]) / across >= limits[4]
    if part and width <= limits[2] and height <= limits[3] and gap <= limits[5]:
        return float(gap)
    return np.inf


@compiled(types.i8[::1](FLOATS_2D, INTS_1D, FLOATS_2D, FLOATS_3D, FLOATS_1D))
def _group(box: Floats, claim: Ints, expected: Floats, sizes: Floats, limits: Floats) -> Ints:
    """Return for each box the first one that it is joined with."""
    count = len(box)
    group, box, claim = np.arange(count), box.copy(), claim.copy()
    while True:
        best, one, other = np.inf, -1, -1
        for first in range(count):
            for second in range(first + 1, count):
                if group[first] == first and group[second] == second:
                    mine, other_claim = claim[first], claim[second]
                    if mine >= 0 and other_claim >= 0 and mine != other_claim:
                        continue
                    claimed = mine >= 0 or other_claim >= 0
                    gap = _gap(box[first], box[second], claimed, sizes, limits)
                    if gap < best:
                        best, one, other = gap, first, second
        if one < 0:
            return group
        box[one] = _united(box[one], box[other])
        claim[one] = max(claim[one], claim[other])
        for row in range(count):
            if group[row] == other:
                group[row] = one
