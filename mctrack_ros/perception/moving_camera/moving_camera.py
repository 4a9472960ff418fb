"""The homography of a camera that pans, tilts and zooms (belief paper, section 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mctrack_ros.ground.homography.projective import ProjectiveMapping
from mctrack_ros.perception.moving_camera.features import KeyImage
from mctrack_ros.perception.moving_camera.ground_lines import GroundLines
from mctrack_ros.perception.moving_camera.turning_camera import TurningCamera

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

LEAST_FEATURES = 12
"""Fewer features that agree do not fix the motion."""
LEAST_LINES = 20
"""Fewer samples of lines may be something else that is bright."""
_FEATURE_PX, _LINE_PX = 1.0, 3.0  # neighbours err alike, so each counts for less than its noise
_START_RAD, _START_ZOOM = 1e-3, 1e-3  # uncertainty of the given calibration
_FREE_RAD, _FREE_ZOOM = 0.1, 0.1  # before features say where the camera turned
_LOST_RAD, _LOST_ZOOM = 4e-3, 4e-3  # growth of the uncertainty in an image without features
_REACH_PX, _FARTHEST_PX = 3.0, 12.0  # search for lines: standard deviations, and at most
_KEPT_SHARE = 0.6  # of the features of a key image; if fewer are found, another is begun
_PERSON_MARGIN_PX = 4  # by which boxes of people are widened


class CameraMotion(StrEnum):
    """What is known about a moving camera."""

    TRACKED = 'tracked'
    LOST = 'lost'


@dataclass(frozen=True, eq=False, slots=True)
class CameraView:
    """
    How a moving camera looks at one image.

    Attributes
    ----------
    state : CameraMotion
        `LOST`: neither features nor lines said how it turned; the mapping is the last one known.
    mapping : ProjectiveMapping
        Image <-> ground.
    features : int
        How many agreed on the motion.
    lines : int
        How many samples of painted lines were found.
    noise_px : float
        Standard deviation of a place in the image that the calibration adds, px.

    """

    state: CameraMotion
    mapping: ProjectiveMapping
    features: int
    lines: int
    noise_px: float


class MovingCamera:
    """
    Follow a camera that turns and zooms about a fixed centre.

    Features carry the calibration from image to image; painted lines pull it back in the
    directions that they fix. Both update one filter of three turns and the focal length.

    Parameters
    ----------
    mapping : ProjectiveMapping
        Of the first image: square pixels, principal point at the centre, no lens distortion.
    lines : sequence of (k, 2) arrays
        Painted lines on the ground, m; none: features alone.

    """

    def __init__(self, mapping: ProjectiveMapping, lines: Sequence[Floats] = ()) -> None:
        self._camera = TurningCamera.of(mapping, _START_RAD, _START_ZOOM)
        self._lines = GroundLines.of(lines)
        self._key: KeyImage | None = None

    def step(self, image: Image, people: ArrayLike = ()) -> CameraView:
        """
        Return how the camera looks at the next image.

        Parameters
        ----------
        image : (height, width, 3) or (height, width) uint8 array
            The image.
        people : (n, 4) array_like
            Left, top, width and height of people in it, px: they are no features.

        """
        grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        grey = np.asarray(grey, np.uint8)
        still = _without(people, grey.shape)
        features = self._turn(grey, still) if self._key else 0
        lines = self._pull(grey, still, features >= LEAST_FEATURES)
        is_known = self._key is None or features >= LEAST_FEATURES or lines >= LEAST_LINES
        if is_known and (self._key is None or features < _KEPT_SHARE * len(self._key.pixel)):
            self._key = KeyImage.of(grey, still, self._camera)
        state = CameraMotion.TRACKED if is_known else CameraMotion.LOST
        mapping = self._camera.mapping()
        return CameraView(state, mapping, features, lines, self._noise_px())

    def _turn(self, grey: Image, still: Image) -> int:
        """Update by the features of the key image; return how many."""
        assert self._key is not None
        rays, pixel = self._key.found_in(grey, still, self._camera)
        if len(rays) < LEAST_FEATURES:
            self._camera = self._camera.grown(_LOST_RAD, _LOST_ZOOM)
            return len(rays)
        free = self._camera.grown(_FREE_RAD, _FREE_ZOOM)
        turned = free.updated(rays, pixel, None, _FEATURE_PX)
        known = turned.carried(self._key.camera, self._key.camera)
        spread = known.covariance + turned.covariance
        self._camera = replace(turned, covariance=spread)
        return len(rays)

    def _pull(self, grey: Image, still: Image, is_turned: bool) -> int:
        """Update by painted lines; return how many samples were found."""
        reach = min(_REACH_PX * max(self._noise_px(), 1.0), _FARTHEST_PX)
        rays, pixel, normal = self._lines.found_in(grey, still, self._camera, reach)
        if len(rays) >= LEAST_LINES:
            before = self._camera
            self._camera = before.updated(rays, pixel, normal, _LINE_PX)
            if self._key is not None and is_turned:
                corrected = self._key.camera.carried(before, self._camera)
                self._key = replace(self._key, camera=corrected)
        return len(rays)

    def _noise_px(self) -> float:
        """Return the root mean square over the image of what the covariance moves a place by."""
        share = np.stack(np.meshgrid([0.1, 0.5, 0.9], [0.1, 0.5, 0.9]), axis=-1).reshape(-1, 2)
        slopes = self._camera.slopes(share * self._camera.size)
        spread = np.einsum('nik,kl,nil->n', slopes, self._camera.covariance, slopes)
        return float(np.sqrt(spread.mean() / 2))


def _without(people: ArrayLike, shape: tuple[int, ...]) -> Image:
    """Return a mask of a shape that is 0 where people are, else 255."""
    still = np.full(shape[:2], 255, np.uint8)
    for left, top, width, height in np.reshape(np.asarray(people, np.float64), (-1, 4)):
        first = int(left) - _PERSON_MARGIN_PX, int(top) - _PERSON_MARGIN_PX
        last = int(left + width) + _PERSON_MARGIN_PX, int(top + height) + _PERSON_MARGIN_PX
        cv2.rectangle(still, first, last, 0, cv2.FILLED)
    return still
