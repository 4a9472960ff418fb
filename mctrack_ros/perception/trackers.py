"""The camera's own trackers, by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Feedback
from mctrack_ros.perception.event_tracker.pipeline import CameraConfig, CameraPipeline
from mctrack_ros.perception.output import CameraOutput
from mctrack_ros.perception.silhouettes import SilhouettePipeline

Image = NDArray[np.uint8]


class CameraTracker(Protocol):
    """One camera, one image after another."""

    def step(self, image: Image, stamp_ns: int, feedback: Feedback | None) -> CameraOutput:
        """Process one image; see `CameraPipeline.step`."""

    def predicted_boxes(self) -> NDArray[np.float64]:
        """
        Return the (n, 4) boxes, px, where the last image was to show tracks, for an overlay.

        A tracker that predicts nothing returns where they are.
        """

    def groups(self) -> list[tuple[int, ...]]:
        """Return the local ids of each group, for an overlay."""


Opener = Callable[[CameraConfig, GroundMapping, Image | None, Image | None], CameraTracker]
TRACKERS: dict[str, Opener] = {
    'groups': CameraPipeline,
    'silhouettes': lambda config, mapping, mask, background: SilhouettePipeline(
        config.silhouettes, mapping, mask, background
    ),
}


def open_camera(
    config: CameraConfig,
    mapping: GroundMapping,
    mask: Image | None = None,
    background: Image | None = None,
) -> CameraTracker:
    """
    Return the tracker that a camera's settings name.

    Parameters
    ----------
    config : CameraConfig
        Names it in ``local_tracker`` and holds its parameters.
    mapping : GroundMapping
        Of the camera.
    mask : (h, w) uint8 array, optional
        0 where the image is to be ignored.
    background : (h, w, 3) uint8 array, optional
        Image without moving objects; unless given, the background is learned first.

    """
    return TRACKERS[config.local_tracker](config, mapping, mask, background)
