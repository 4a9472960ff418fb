"""What a camera looks at: its background, learned or given, and the foreground without shadows."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.perception.background.model import Background, BackgroundConfig
from mctrack_ros.perception.background.shadows import ShadowConfig, Shadows

Image = NDArray[np.uint8]


class Scene:
    """
    Subtracts the background from a camera's images, as all camera trackers do.

    Parameters
    ----------
    config : BackgroundConfig
        Parameters of the background.
    shadows : ShadowConfig
        Parameters of the shadows.
    mapping : GroundMapping
        Of the camera.
    scale : float
        Pixels of the camera's image to one of those that come.
    mask : (h, w) uint8 array or None
        0 where the image is to be ignored.
    given : (h, w, 3) uint8 array or None
        Image without moving objects; None: the background is learned first.

    Attributes
    ----------
    background : Background
        The model.
    shadows : Shadows
        What is known of them.

    """

    def __init__(
        self,
        config: BackgroundConfig,
        shadows: ShadowConfig,
        mapping: GroundMapping,
        scale: float,
        mask: Image | None,
        given: Image | None,
    ) -> None:
        self.background = Background(config)
        self.shadows = Shadows(shadows, mapping, scale)
        self._mask, self._given = mask, given
        if given is not None:
            self.background.begin(given)

    def begin_anew(self) -> None:
        """Forget what was learned, as the images are of another time."""
        self.shadows.restart()
        self.background.restart()
        if self._given is not None:
            self.background.begin(self._given)

    @property
    def noise(self) -> float:
        """Standard deviation of a channel's noise, grey levels; 0: unknown."""
        return self.background.noise or 0.0

    def foreground(self, image: Image, stamp_ns: int) -> Image | None:
        """
        Tell what in an image differs from the background and is no shadow.

        Parameters
        ----------
        image : (h, w, 3) uint8 array
            The image.
        stamp_ns : int
            Its time, ns; later than the last.

        Returns
        -------
        (h, w) uint8 array or None
            255 where it does, until the next call; None while the background is learned.

        """
        found = self.background.apply(image, stamp_ns)
        model = self.background.model
        if found is None or model is None:
            return None
        self.shadows.take_out(image, model, found, self.noise, stamp_ns)
        if self._mask is not None:
            cv2.bitwise_and(found, self._mask, found)
        return found
