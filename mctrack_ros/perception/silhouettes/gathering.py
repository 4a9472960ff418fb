"""Before step 1, beyond the paper: fragments that fit one body at that spot are one silhouette."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_1D, FLOATS_2D, FLOATS_3D, compiled, inner
from mctrack_ros.config import parameter
from mctrack_ros.perception.silhouettes.components import Silhouettes
from mctrack_ros.perception.silhouettes.features import Floats, Ints, stacked
from mctrack_ros.perception.sizes import SizeTable, metre_at


@dataclass(frozen=True)
class GatheringConfig:
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
        0.3, 'greatest gap between parts of a vehicle [m]', minimum=0.0
    )

    def limits(self) -> Floats:
        """Return the six as an array."""
        return np.array(
            [
                self.person_width_m, self.person_height_m, self.vehicle_width_m,
                self.vehicle_height_m, self.vehicle_part_m, self.vehicle_gap_m,
            ]
        )  # fmt: skip


def gathered(silhouettes: Silhouettes, sizes: SizeTable, config: GatheringConfig) -> Silhouettes:
    """
    Join fragments, the closest first, while the union is no larger than one body.

    Low contrast leaves a head, a belt and two shoes of a pedestrian. The paper's steps 6 and 7
    find them together again only if the object was whole before, and it may never be: it enters
    in pieces. How tall a person looks where is known from the camera's calibration.

    Parameters
    ----------
    silhouettes : Silhouettes
        Of a picture.
    sizes : SizeTable
        Of the camera.
    config : GatheringConfig
        Parameters.

    Returns
    -------
    Silhouettes
        With fewer rows, in the order of their first fragments.

    """
    shapes = silhouettes.shapes
    if config.person_height_m == 0.0 or len(shapes) < 2:
        return silhouettes
    group = _group(shapes.box, sizes.table, config.limits())
    names, row = np.unique(group, return_inverse=True)
    if len(names) == len(shapes):
        return silhouettes
    united = stacked(*(shapes.select(np.flatnonzero(group == name)).united() for name in names))
    row_of = np.r_[-1, row].astype(np.int64)[silhouettes.row_of + 1]
    return Silhouettes(united, silhouettes.labels, row_of, silhouettes.grey)


@inner
def _united(one: Floats, other: Floats) -> NDArray[np.float64]:
    left, top = min(one[0], other[0]), min(one[1], other[1])
    right = max(one[0] + one[2], other[0] + other[2])
    bottom = max(one[1] + one[3], other[1] + other[3])
    return np.array([left, top, right - left, bottom - top])


@inner
def _gap(one: Floats, other: Floats, sizes: Floats, limits: Floats) -> float:
    """Return the gap, m, between two boxes that may be one body; else infinity."""
    both = _united(one, other)
    across, upright, _ = metre_at(sizes, both[0] + both[2] / 2, both[1] + both[3])
    if not (across > 0.0 and upright > 0.0):
        return np.inf
    width, height = both[2] / across, both[3] / upright
    gap_x = max(one[0], other[0]) - min(one[0] + one[2], other[0] + other[2])
    gap_y = max(one[1], other[1]) - min(one[1] + one[3], other[1] + other[3])
    gap = max(max(gap_x / across, gap_y / upright), 0.0)
    if width <= limits[0] and height <= limits[1]:
        return float(gap)
    part = min(one[2], other[2]) / across >= limits[4]
    if part and width <= limits[2] and height <= limits[3] and gap <= limits[5]:
        return float(gap)
    return np.inf


@compiled(types.i8[::1](FLOATS_2D, FLOATS_3D, FLOATS_1D))
def _group(box: Floats, sizes: Floats, limits: Floats) -> Ints:
    """Return for each box the first one that it is joined with."""
    count = len(box)
    group, box = np.arange(count), box.copy()
    while True:
        best, one, other = np.inf, -1, -1
        for first in range(count):
            for second in range(first + 1, count):
                if group[first] == first and group[second] == second:
                    gap = _gap(box[first], box[second], sizes, limits)
                    if gap < best:
                        best, one, other = gap, first, second
        if one < 0:
            return group
        box[one] = _united(box[one], box[other])
        for row in range(count):
            if group[row] == other:
                group[row] = one
