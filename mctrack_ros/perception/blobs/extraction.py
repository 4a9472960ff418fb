"""From the foreground mask to blobs: noise removed, fragments of one person joined."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import types
from numpy.typing import NDArray

from mctrack_ros.compiled import FLOATS_1D, FLOATS_2D, compiled, inner
from mctrack_ros.config import parameter
from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.blobs.connected_components import component_boxes
from mctrack_ros.perception.blobs.fragments import from_left_to_right, joined, trimmed
from mctrack_ros.perception.blobs.morphology import check_kernels, opened
from mctrack_ros.perception.geometry.person_size import SizeTable

Booleans = NDArray[np.bool_]
Floats = NDArray[np.float64]
SMALLEST_HEIGHT, LARGEST_HEIGHT = 0.35, 6.0
"""Heights of a blob, in expected ones: from a person whose legs are not seen to a large group."""
SMALLEST_AREA = 0.08
"""Least foreground, as a share of the expected box, of which a person fills a third and more."""


@dataclass(frozen=True)
class BlobConfig:
    """Parameters of `find_blobs`; kernels are odd, so that nothing is shifted."""

    opening_px: int = parameter(3, 'what is narrower is noise [px]', minimum=1, maximum=31)
    leg_contrast: float = parameter(
        1.7,
        'a narrower part below a blob is a leg if it differs from the background by so many '
        'thresholds; 25: there are none',
        minimum=1.0,
        maximum=25.0,
    )
    closing_px: int = parameter(
        1, 'gaps narrower than this are closed [px]', minimum=1, maximum=63
    )
    halo_share: float = parameter(
        0.3,
        "difference below which a blob's rim is cut, as a share of its mean",
        minimum=0.0,
        maximum=1.0,
    )
    person_height_m: float = parameter(1.75, 'height of what is tracked [m]', minimum=0.05)
    person_width_m: float = parameter(0.6, 'width of what is tracked [m]', minimum=0.05)
    farthest_height_px: float = parameter(
        0.0,
        'smallest height of a person; places where it would be smaller are too far away; 0: a '
        'third of the median over the ground in the image [px]',
        minimum=0.0,
    )

    def __post_init__(self) -> None:
        """Refuse even kernels."""
        check_kernels(opening_px=self.opening_px, closing_px=self.closing_px)


@dataclass(frozen=True, eq=False, slots=True)
class Blobs:
    """
    Connected foreground, one row each.

    Attributes
    ----------
    box : (n, 4) float64 array
        Left, top, width, height, px.
    area : (n,) float64 array
        Foreground, px².
    foot : (n, 2) float64 array
        Foot points, px.
    position : (n, 2) float64 array
        Where the foot stands on the ground, m.
    expected : (n, 2) float64 array
        Width and height of one person there, px.
    truncated : (n,) bool array
        Touches the image's edge.

    """

    box: Floats
    area: Floats
    foot: Floats
    position: Floats
    expected: Floats
    truncated: NDArray[np.bool_]

    def __len__(self) -> int:
        """Return the number of blobs."""
        return len(self.box)

    def select(self, mask: NDArray[np.bool_]) -> Blobs:
        """Return the rows that a mask picks."""
        return Blobs(
            self.box[mask],
            self.area[mask],
            self.foot[mask],
            self.position[mask],
            self.expected[mask],
            self.truncated[mask],
        )


def clean_mask(
    mask: NDArray[np.uint8], difference: NDArray[np.uint8], threshold: float, config: BlobConfig
) -> NDArray[np.uint8]:
    """
    Remove specks and close gaps (event-tracking paper, section 4.2), but keep thin legs.

    Parameters
    ----------
    mask, difference : (h, w) uint8 arrays
        Foreground, not zero, and difference from the background.
    threshold : float
        Difference from which it is foreground, grey levels.
    config : BlobConfig
        Parameters.

    Returns
    -------
    (h, w) uint8 array
        Foreground, 255.

    """
    cleaned = opened(mask, difference, config.opening_px, config.leg_contrast * threshold)
    if config.closing_px > 1:
        kernel = np.ones((config.closing_px, config.closing_px), np.uint8)
        cv2.morphologyEx(cleaned, cv2.MORPH_CLOSE, kernel, cleaned)
    return cleaned


def find_blobs(
    mask: NDArray[np.uint8],
    difference: NDArray[np.uint8],
    mapping: GroundMapping,
    sizes: SizeTable,
    scale: float,
    config: BlobConfig,
) -> Blobs:
    """
    Find what may be persons or groups of them in a cleaned mask.

    Parameters
    ----------
    mask : (h, w) uint8 array
        Foreground, 255; the mapping's image reduced by `scale`.
    difference : (h, w) uint8 array
        Of that image from the background.
    mapping : GroundMapping
        Of the camera.
    sizes : SizeTable
        Tells what size a person has where.
    scale : float
        Pixels of the image to one of the mask.
    config : BlobConfig
        Parameters.

    Returns
    -------
    Blobs
        From left to right; fragments joined, specks and what is impossibly large left out.

    """
    box = from_left_to_right(component_boxes(mask), config.opening_px**2)
    box = joined(box * scale, sizes.table, config.person_width_m, config.person_height_m)
    found = trimmed(mask, difference, box / scale, config.halo_share)
    box, area = found[:, :4] * scale, found[:, 4] * scale**2
    blobs, plausible = describe(box, area, mapping, sizes, config)
    return blobs.select(plausible)


def describe(
    box: Floats, area: Floats, mapping: GroundMapping, sizes: SizeTable, config: BlobConfig
) -> tuple[Blobs, Booleans]:
    """Return where boxes stand, how large a person is there, and which may be persons."""
    foot = sizes.foot_of(box)
    expected = sizes.per_metre(foot) * [config.person_width_m, config.person_height_m]
    width, height = mapping.image_size
    truncated, plausible = _judged(
        box, area, expected, float(width), float(height), config.farthest_height_px
    )
    position = mapping.ground_from_image(foot)
    return Blobs(box, area, foot, position, expected, truncated), plausible


@compiled(types.UniTuple(types.b1[::1], 2)(FLOATS_2D, FLOATS_1D, FLOATS_2D, *[types.f8] * 3))
def _judged(
    box: Floats, area: Floats, expected: Floats, width: float, height: float, farthest: float
) -> tuple[Booleans, Booleans]:
    """Tell which boxes touch the edge of an image, and which may be persons by their size."""
    truncated, plausible = np.empty(len(box), np.bool_), np.empty(len(box), np.bool_)
    for row in range(len(box)):
        left, top, across, down = box[row]
        usual_width, usual_height = expected[row]
        far_edge = left + across >= width - 1 or top + down >= height - 1
        truncated[row] = left <= 1 or top <= 1 or far_edge
        least = SMALLEST_HEIGHT * usual_height * (0.5 if truncated[row] else 1.0)
        plausible[row] = (
            usual_height >= farthest
            and least <= down <= LARGEST_HEIGHT * usual_height
            and area[row] >= SMALLEST_AREA * usual_width * usual_height
        )
    return truncated, plausible


@inner
def shared_area(first: Floats, second: Floats) -> float:
    """Return the intersection, px², of two boxes, (4,), in compiled functions."""
    across = min(first[0] + first[2], second[0] + second[2]) - max(first[0], second[0])
    down = min(first[1] + first[3], second[1] + second[3]) - max(first[1], second[1])
    return float(max(across, 0.0) * max(down, 0.0))


def overlap(first: Floats, second: Floats) -> Floats:
    """Return the (n, m) intersections, px², of (n, 4) and (m, 4) boxes."""
    low = np.maximum(first[:, None, :2], second[None, :, :2])
    high = np.minimum(
        (first[:, :2] + first[:, 2:])[:, None], (second[:, :2] + second[:, 2:])[None]
    )
    extent: Floats = np.maximum(high - low, 0.0)
    result: Floats = extent[..., 0] * extent[..., 1]
    return result


def iou(first: Floats, second: Floats) -> Floats:
    """Return the (n, m) intersections over unions of (n, 4) and (m, 4) boxes."""
    shared = overlap(first, second)
    area = np.prod(first[:, 2:], axis=1)[:, None] + np.prod(second[:, 2:], axis=1)[None]
    return np.asarray(shared / np.maximum(area - shared, 1e-9))


@inner
def iou_of_two(first: Floats, second: Floats) -> float:
    """Return the intersection over union of two boxes, (4,), in compiled functions."""
    shared = shared_area(first, second)
    area = first[2] * first[3] + second[2] * second[3]
    return float(shared / max(area - shared, 1e-9))
