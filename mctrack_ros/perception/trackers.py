"""Registry of camera trackers: what each is, all of them by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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


class Given(NamedTuple):
    """
    What a camera's tracker is given beside its parameters.

    Attributes
    ----------
    name : str
        Of the camera.
    mapping : GroundMapping
        Of the camera.
    mask : (h, w) uint8 array, optional
        0 where the image is to be ignored.
    background : (h, w, 3) uint8 array, optional
        Image without moving objects; unless given, the background is learned first.
    lines : sequence of (n, 2) arrays
        Painted on the ground, m.

    """

    name: str
    mapping: GroundMapping
    mask: Image | None = None
    background: Image | None = None
    lines: Sequence[NDArray[np.float64]] = ()


Opener = Callable[[Any, Given], CameraTracker]


class CameraMethod(NamedTuple):
    """
    A tracker that a camera can have.

    Attributes
    ----------
    config : type
        Its parameters.
    open : callable
        Makes one of its parameters and what is given.
    messages : tuple of type
        Message types of every image, each on the topic of its type.
    feedback : type
        Message type of its feedback, on the topic of that type.
    first_pass : bool
        Whether the background of a recording is learned from all of it before it is tracked.

    """

    config: type[CameraConfig]
    open: Opener
    messages: tuple[type[Message], ...] = (Detections,)
    feedback: type[Rows] = Feedback
    first_pass: bool = False


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
        lambda config, given: SilhouettePipeline(config.silhouettes, *given[1:4]),
    )


def _likelihood_grid() -> CameraMethod:
    from mctrack_ros.perception.likelihood_grid.config import LikelihoodCameraConfig
    from mctrack_ros.perception.likelihood_grid.pipeline import MESSAGES, LikelihoodCamera

    return CameraMethod(
        LikelihoodCameraConfig,
        lambda config, given: LikelihoodCamera(config, *given[1:4]),
        MESSAGES,
        first_pass=True,
    )


def _belief() -> CameraMethod:
    from mctrack_ros.perception.belief.config import BeliefCameraConfig
    from mctrack_ros.perception.belief.pipeline import MESSAGES, BeliefCamera

    return CameraMethod(
        BeliefCameraConfig, lambda config, given: BeliefCamera(config, *given), MESSAGES, Belief
    )


TRACKERS: dict[str, CameraMethod | Deferred] = {
    'event_tracker': CameraMethod(
        EventTrackerConfig,
        lambda config, given: EventTracker(config, *given[1:4]),
        MESSAGES,
        first_pass=True,
    ),
    'silhouettes': Deferred(_silhouettes),
    'likelihood_grid': Deferred(_likelihood_grid),
    'belief': Deferred(_belief),
}
CAMERA: OneOf[CameraConfig] = OneOf(
    'local_tracker',
    'event_tracker',
    "the camera's own tracker: filters on the ground with groups, the silhouettes paper's, the "
    "likelihood-grid paper's, or the view filters of belief propagation",
    TRACKERS,
)
"""The choice of a camera's tracker, with its parameters."""


def camera_method(config: CameraConfig) -> CameraMethod:
    """Return the tracker that a camera's parameters are of."""
    method = TRACKERS[config.local_tracker]
    return method.chosen if isinstance(method, Deferred) else method


def open_camera(config: CameraConfig, given: Given) -> CameraTracker:
    """
    Return the tracker that a camera's parameters are of.

    Raises
    ------
    ConfigError
        If that cannot do with what is given.

    """
    return camera_method(config).open(config, given)


def open_buffer(config: CameraConfig, period_ns: int, delay_ns: int) -> RowsBuffer[Any]:
    """Return what keeps the feedback of a camera's tracker; see `RowsBuffer`."""
    if camera_method(config).feedback is Feedback:
        return FeedbackBuffer(period_ns, delay_ns)
    return RowsBuffer(period_ns, delay_ns)
