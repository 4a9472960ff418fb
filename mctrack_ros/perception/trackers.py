"""Registry of camera trackers: what each is, all of them by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.config import OneOf
from mctrack_ros.ground import GroundMapping
from mctrack_ros.interfaces import Belief, Detections, Feedback, Message, Rows
from mctrack_ros.perception.config import CameraConfig
from mctrack_ros.perception.event_tracker.config import EventTrackerConfig
from mctrack_ros.perception.event_tracker.pipeline import MESSAGES, EventTracker
from mctrack_ros.perception.feedback.buffer import FeedbackBuffer, RowsBuffer
from mctrack_ros.perception.output import CameraOutput

Image = NDArray[np.uint8]


class CameraTracker(Protocol):
    """One camera, one image after another."""

    def step(self, image: Image, stamp_ns: int, feedback: Any) -> CameraOutput:
        """
        Process one image; see `EventTracker.step`.

        The feedback is of the type that the tracker's `CameraMethod` names, or None.
        """

    def predicted_boxes(self) -> NDArray[np.float64]:
        """
        Return the (n, 4) boxes, px, where the last image was to show tracks, for an overlay.

        A tracker that predicts nothing returns where they are.
        """

    def groups(self) -> list[tuple[int, ...]]:
        """Return the local ids of each group, for an overlay."""


Opener = Callable[[Any, str, GroundMapping, Image | None, Image | None], CameraTracker]


class CameraMethod(NamedTuple):
    """
    A tracker that a camera can have.

    Attributes
    ----------
    config : type
        Its parameters.
    open : callable
        Makes one of parameters, the camera's name, mapping, mask and background; see
        `open_camera`.
    messages : tuple of type
        Message types of every image, each on the topic of its type.
    feedback : type
        Message type of its feedback, on the topic of that type.

    """

    config: type[CameraConfig]
    open: Opener
    messages: tuple[type[Message], ...] = (Detections,)
    feedback: type[Rows] = Feedback


class Deferred:
    """A tracker that is imported when it is chosen, as its loops take time to load."""

    def __init__(self, method: Callable[[], CameraMethod]) -> None:
        self._method = cache(method)

    @property
    def config(self) -> type[CameraConfig]:
        """Its parameters."""
        return self._method().config

    @property
    def chosen(self) -> CameraMethod:
        """The tracker."""
        return self._method()


def _silhouettes() -> CameraMethod:
    from mctrack_ros.perception.silhouettes import SilhouetteCameraConfig, SilhouettePipeline

    return CameraMethod(
        SilhouetteCameraConfig,
        lambda config, name, *given: SilhouettePipeline(config.silhouettes, *given),
    )


def _likelihood_grid() -> CameraMethod:
    from mctrack_ros.perception.likelihood_grid.config import LikelihoodCameraConfig
    from mctrack_ros.perception.likelihood_grid.pipeline import MESSAGES, LikelihoodCamera

    return CameraMethod(
        LikelihoodCameraConfig,
        lambda config, name, *given: LikelihoodCamera(config, *given),
        MESSAGES,
    )


def _belief() -> CameraMethod:
    from mctrack_ros.perception.belief.config import BeliefCameraConfig
    from mctrack_ros.perception.belief.pipeline import MESSAGES, BeliefCamera

    return CameraMethod(BeliefCameraConfig, BeliefCamera, MESSAGES, Belief)


TRACKERS: dict[str, CameraMethod | Deferred] = {
    'groups': CameraMethod(
        EventTrackerConfig, lambda config, name, *given: EventTracker(config, *given), MESSAGES
    ),
    'silhouettes': Deferred(_silhouettes),
    'likelihood_grid': Deferred(_likelihood_grid),
    'belief': Deferred(_belief),
}
CAMERA: OneOf[CameraConfig] = OneOf(
    'local_tracker',
    'groups',
    "the camera's own tracker: filters on the ground with groups, the silhouettes paper's, the "
    "likelihood-grid paper's, or the view filters of belief propagation",
    TRACKERS,
)
"""The choice of a camera's tracker, with its parameters."""


def camera_method(config: CameraConfig) -> CameraMethod:
    """Return the tracker that a camera's parameters are of."""
    method = TRACKERS[config.local_tracker]
    return method.chosen if isinstance(method, Deferred) else method


def open_camera(
    config: CameraConfig,
    mapping: GroundMapping,
    mask: Image | None = None,
    background: Image | None = None,
    name: str = '',
) -> CameraTracker:
    """
    Return the tracker that a camera's parameters are of.

    Parameters
    ----------
    config : CameraConfig
        The parameters.
    mapping : GroundMapping
        Of the camera.
    mask : (h, w) uint8 array, optional
        0 where the image is to be ignored.
    background : (h, w, 3) uint8 array, optional
        Image without moving objects; unless given, the background is learned first.
    name : str
        Of the camera.

    """
    return camera_method(config).open(config, name, mapping, mask, background)


def open_buffer(config: CameraConfig, period_ns: int, delay_ns: int) -> RowsBuffer[Any]:
    """Return what keeps the feedback of a camera's tracker; see `RowsBuffer`."""
    if camera_method(config).feedback is Feedback:
        return FeedbackBuffer(period_ns, delay_ns)
    return RowsBuffer(period_ns, delay_ns)
