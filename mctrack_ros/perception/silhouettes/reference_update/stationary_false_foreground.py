"""Silhouettes that nobody made: what is still, with no object there that came to rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_2D, compiled
from mctrack_ros.config import parameter
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.blobs.extraction import overlap
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.silhouettes.features import Floats, Ints, Mask
from mctrack_ros.perception.silhouettes.foreground.components import Silhouettes
from mctrack_ros.perception.silhouettes.objects import ObjectList
from mctrack_ros.perception.silhouettes.reference_update.absorbed import window_of
from mctrack_ros.perception.silhouettes.reference_update.stationarity import Seconds, Stationarity


@dataclass(frozen=True)
class FalseForegroundConfig:
    """Parameters of `without_false_foreground`."""

    still_s: float = parameter(
        1.0,
        'a silhouette without an object is left out after it was unchanged for so long; 0: none '
        'is, as printed [s]',
        minimum=0.0,
    )
    still_share: float = parameter(
        0.8, 'share of its pixels that must be unchanged', minimum=0.0, maximum=1.0
    )
    claim_share: float = parameter(
        0.3,
        'share of its box that an expected object must cover to own it',
        minimum=0.0,
        maximum=1.0,
    )
    slow_mps: float = parameter(
        0.5, 'speed below which a pedestrian may have come to rest [m/s]', minimum=0.0
    )


def without_false_foreground(
    silhouettes: Silhouettes,
    still: Stationarity,
    objects: ObjectList,
    sizes: SizeTable,
    image: NDArray[np.uint8],
    background: Background,
    config: FalseForegroundConfig,
) -> Silhouettes:
    """
    Put silhouettes that nobody made into the background and leave them out; beyond the paper.

    Paint and glass that somebody's reflection lit up, the rest of a hole, the edge of a car in
    another light: they stand still from their first moment. Whatever else stands still came
    there, so an object is there that is slow.

    Parameters
    ----------
    silhouettes : Silhouettes
        Of the image.
    still : Stationarity
        For how long its pixels have looked the same.
    objects : ObjectList
        Where they are expected.
    sizes : SizeTable
        Of the camera.
    image : (h, w, 3) uint8 array
        The smoothed image.
    background : Background
        Is changed.
    config : FalseForegroundConfig
        Parameters.

    """
    shapes = silhouettes.shapes
    if config.still_s == 0.0 or not len(shapes) or background.model is None:
        return silhouettes
    old = _old_pixels(silhouettes.labels, still.seconds, shapes.box, config.still_s)
    is_false = (old >= config.still_share * shapes.area) & (old > 0)
    if not is_false.any():
        return silhouettes
    box = objects.box[_may_rest(objects, sizes, config)]
    share = overlap(shapes.box, box) / shapes.box[:, 2:].prod(axis=1)[:, None]
    is_false &= (share < config.claim_share).all(axis=1)
    rows = np.flatnonzero(is_false).tolist()
    for row in rows:
        window = window_of(shapes.box[row])
        own = silhouettes.labels[window] == row + 1
        background.model[window][own] = image[window][own]
        still.seconds[window][own] = 0.0
    return silhouettes.without(rows) if rows else silhouettes


def _may_rest(objects: ObjectList, sizes: SizeTable, config: FalseForegroundConfig) -> Mask:
    """Tell which objects, (n,), are vehicles or slow."""
    speed_px = np.hypot(objects.velocity[:, 0], objects.velocity[:, 1])
    metre_px = sizes.per_metre(sizes.foot_of(objects.box))[:, 1]
    vehicle = objects.class_id == ClassCode.VEHICLE
    return np.asarray(vehicle | ~(speed_px > config.slow_mps * metre_px))


@compiled(
    types.i8[::1](
        types.Array(types.u2, 2, 'C', readonly=True),
        types.Array(types.f4, 2, 'C', readonly=True),
        FLOATS_2D,
        types.f8,
    )
)
def _old_pixels(labels: NDArray[np.uint16], seconds: Seconds, box: Floats, least_s: float) -> Ints:
    """Return how many pixels of each silhouette have looked the same for long."""
    count = np.zeros(len(box), np.int64)
    for row in range(len(box)):
        left, top, width, height = box[row]
        for y in range(int(top), int(top + height)):
            for x in range(int(left), int(left + width)):
                if labels[y, x] == row + 1 and seconds[y, x] >= least_s:
                    count[row] += 1
    return count
