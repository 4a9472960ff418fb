"""Before step 1, beyond the paper: what is faint of a small body counts to it."""

from __future__ import annotations

import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import BYTES_2D, INTS_1D, INTS_2D, compiled
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.silhouettes.features import AREA, BINS, HISTOGRAM, Ints, Shapes
from mctrack_ros.perception.silhouettes.foreground.components import Silhouettes
from mctrack_ros.perception.silhouettes.foreground.fragment_merging import FragmentMergingConfig

Grey = NDArray[np.uint8]


def with_faint(
    silhouettes: Silhouettes,
    background: Background,
    sizes: SizeTable,
    config: FragmentMergingConfig,
    small_px: float,
) -> Silhouettes:
    """
    Count what is faint between the fragments of a small silhouette as part of it.

    Of somebody far away in the grey of the ground a head and two hands are foreground, too
    little to be an object; the coat between them differs from the ground as little as a shadow
    does. Alone it may be one, or noise; between a head and hands it is the coat.

    Parameters
    ----------
    silhouettes : Silhouettes
        Of an image, gathered.
    background : Background
        Of the camera.
    sizes : SizeTable
        Of the camera.
    config : FragmentMergingConfig
        How large a person is, and what is faint.
    small_px : float
        Area below which a silhouette is small, px².

    """
    shapes = silhouettes.shapes
    if config.faint_sigmas == 0.0 or not len(shapes):
        return silhouettes
    extent = shapes.box[:, 2:] / sizes.per_metre(sizes.foot_of(shapes.box))
    largest = config.person_width_m, config.person_height_m
    small = (shapes.area < small_px) & (extent <= largest).all(axis=1)
    if not small.any():
        return silhouettes
    rows = np.flatnonzero(small)
    counts = _counted(
        np.ascontiguousarray(silhouettes.grey),
        background.difference,
        silhouettes.labels,
        silhouettes.row_of,
        shapes.box[rows].astype(np.int64),
        config.faint_sigmas * (background.noise or 0.0),
    )
    vector = shapes.vector.copy()
    vector[rows, HISTOGRAM] += counts
    vector[rows, AREA] += counts.sum(axis=1)
    shapes = Shapes(vector, shapes.box)
    return Silhouettes(shapes, silhouettes.labels, silhouettes.row_of, silhouettes.grey)


@compiled(
    types.i8[:, ::1](
        BYTES_2D,
        BYTES_2D,
        types.Array(types.u2, 2, 'C', readonly=True),
        INTS_1D,
        INTS_2D,
        types.f8,
    )
)
def _counted(
    grey: Grey,
    difference: Grey,
    labels: NDArray[np.uint16],
    row_of: Ints,
    box: Ints,
    step: float,
) -> Ints:
    """Return how many faint pixels of each grey, (n, 16), boxes (n, 4) hold of no silhouette."""
    counts = np.zeros((len(box), BINS), np.int64)
    for row in range(len(box)):
        left, top, width, height = box[row]
        for y in range(top, top + height):
            for x in range(left, left + width):
                if difference[y, x] > step and row_of[labels[y, x]] < 0:
                    counts[row, grey[y, x] // (256 // BINS)] += 1
    return counts
