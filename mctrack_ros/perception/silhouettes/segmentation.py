"""The silhouettes of an image, and the background that they are told from."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.background.model import Background
from mctrack_ros.perception.background.scene import Scene
from mctrack_ros.perception.geometry.person_size import SizeTable
from mctrack_ros.perception.output import check_image
from mctrack_ros.perception.silhouettes.config import SilhouetteConfig
from mctrack_ros.perception.silhouettes.foreground.components import Silhouettes, find_silhouettes
from mctrack_ros.perception.silhouettes.objects import ObjectList
from mctrack_ros.perception.silhouettes.reference_update.absorption import Absorption
from mctrack_ros.perception.silhouettes.reference_update.holes import patched, without_still_holes
from mctrack_ros.perception.silhouettes.reference_update.stationary_false_foreground import (
    without_false_foreground,
)

Image = NDArray[np.uint8]
SPECK_SHARE = 0.3  # of a difference of what is too narrow to be anybody, learned in one look


class Subtracted(NamedTuple):
    """
    What differs from the background in an image.

    Attributes
    ----------
    image : (h, w, 3) uint8 array
        The smoothed image.
    mask : (h, w) uint8 array
        255 where it differs.

    """

    image: Image
    mask: Image


class Segmentation:
    """
    Subtracts the background, which follows the images, and finds silhouettes in what is left.

    Parameters
    ----------
    config, mapping, mask, background
        As `SilhouettePipeline` takes them.

    """

    def __init__(
        self,
        config: SilhouetteConfig,
        mapping: GroundMapping,
        mask: Image | None,
        background: Image | None,
    ) -> None:
        self._config, own = config, config.background
        if background is not None:
            check_image(background, mapping.image_size)
            background = self._smoothed(background)
        self._scene = Scene(own.background(), own.shadows(), mapping, 1.0, mask, background)
        self._nobody = np.zeros(mapping.image_size[::-1], np.uint8)
        self._absorption = Absorption(config.absorption)

    @property
    def background(self) -> Background:
        """The model of the background."""
        return self._scene.background

    def restart(self) -> None:
        """Forget what was inserted into the background."""
        self._absorption.restart()

    def begin_anew(self) -> None:
        """Forget the background, as the images are of another time."""
        self._scene.begin_anew()

    def foreground(self, image: Image, stamp_ns: int) -> Subtracted | None:
        """
        Return what differs; all else but what may be a shadow is learned.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            BGR image.
        stamp_ns : int
            Its time, ns.

        Returns
        -------
        Subtracted or None
            None while the background is learned.

        """
        smooth = self._smoothed(image)
        mask, background = self._scene.foreground(smooth, stamp_ns), self.background
        if mask is None:
            return None
        apart, least = background.difference, background.threshold
        kept = np.asarray(cv2.threshold(apart, least, 255, cv2.THRESH_BINARY)[1], np.uint8)
        background.learn(smooth, kept, self._nobody, self._nobody, stamp_ns)
        self._absorption.watch(background, smooth, mask, stamp_ns)
        return Subtracted(smooth, mask)

    def silhouettes(
        self, foreground: Subtracted, objects: ObjectList, sizes: SizeTable
    ) -> Silhouettes:
        """Return the silhouettes of an image; a few times a second, mend the background."""
        (image, mask), config = foreground, self._config
        background, still = self.background, self._absorption.still
        grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)
        if not self._absorption.looked:
            return find_silhouettes(mask, grey, config.components)
        mask = without_still_holes(
            mask, grey, image, still, background, config.components, config.holes
        )
        found = find_silhouettes(mask, grey, config.components)
        if config.components.learn_specks:
            _learn_specks(image, np.where(found.labels == 0, mask, np.uint8(0)), background)
        found = patched(found, image, background, config.holes)
        return without_false_foreground(
            found, still, objects, sizes, image, background, config.stationary_false_foreground
        )

    def insert_resting(
        self,
        objects: ObjectList,
        foreground: Subtracted,
        silhouettes: Silhouettes,
        stamp_ns: int,
    ) -> NDArray[np.bool_]:
        """Put what has come to rest into the background; tell which objects, (n,), that are."""
        image, mask = foreground
        return self._absorption.insert_resting(
            objects, self.background, image, mask, silhouettes.labels, stamp_ns
        )

    def _smoothed(self, image: Image) -> Image:
        """Return an image as the background sees it."""
        side = self._config.background.smoothing_px
        return image if side == 1 else cv2.blur(image, (side, side))  # type: ignore[return-value]


def _learn_specks(image: Image, specks: Image, background: Background) -> None:
    """Let the background follow an image where a mask is not zero."""
    assert background.model is not None
    learned = cv2.addWeighted(background.model, 1 - SPECK_SHARE, image, SPECK_SHARE, 0.0)
    cv2.copyTo(learned, specks, background.model)
