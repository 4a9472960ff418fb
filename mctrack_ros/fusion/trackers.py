"""The seam of fusion's trackers: what each is, and all of them by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from mctrack_ros.config import OneOf
from mctrack_ros.fusion.batcher import Batcher
from mctrack_ros.fusion.config import FusionConfig, JointConfig
from mctrack_ros.fusion.explain.recorder import DecisionRecorder
from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.joint_tracker.pipeline import JointTracker
from mctrack_ros.fusion.measurements.admission import unusable_count
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.interfaces import Detections, Rows, RowsTick


class FusionTracker(Protocol):
    """All cameras, one tick after another."""

    @property
    def next_id(self) -> int:
        """Id of the next track that begins; ids ascend."""
        ...

    @property
    def bias(self) -> CameraBias | None:
        """How the cameras disagree, in the site's order; None: that is not estimated."""
        ...

    def step(self, tick: RowsTick[Any], recorder: DecisionRecorder | None = None) -> FusionOutput:
        """
        Process one tick; see `JointTracker.step`.

        Its messages are of the type that the tracker's `FusionMethod` names. The recorder is one
        of `open_recorder`.
        """
        ...

    def feedback(self) -> Rows:
        """Return what the cameras are told after the last tick, stamped with it."""
        ...


Opener = Callable[[Any, tuple[str, ...], int], FusionTracker]


class FusionMethod(NamedTuple):
    """
    A tracker that fusion can have.

    Attributes
    ----------
    config : type
        Its parameters.
    open : callable
        Makes one of parameters, the cameras' names and the first id; see `open_fusion`.
    messages : type
        What it is told by the cameras, on the topic of that row type.
    unusable : callable
        Tells how many rows of such a message cannot be used.
    recorder : callable, optional
        Makes what takes down why a tick is decided as it is; None: this tracker does not say.

    """

    config: type[FusionConfig]
    open: Opener
    messages: type[Rows]
    unusable: Callable[[Any], int]
    recorder: Callable[[], DecisionRecorder] | None = None


TRACKERS: dict[str, FusionMethod] = {
    'joint': FusionMethod(JointConfig, JointTracker, Detections, unusable_count, DecisionRecorder),
}
FUSION: OneOf[FusionConfig] = OneOf(
    'tracker', 'joint', 'How all cameras are tracked with: their detections jointly', TRACKERS
)
"""The choice of fusion's tracker, with its parameters."""


def fusion_method(config: FusionConfig) -> FusionMethod:
    """Return the tracker that parameters are of."""
    return TRACKERS[config.tracker]


def open_fusion(
    config: FusionConfig, cameras: tuple[str, ...], first_id: int = 1
) -> FusionTracker:
    """
    Return the tracker that parameters are of.

    Parameters
    ----------
    config : FusionConfig
        The parameters.
    cameras : tuple of str
        Names in the site's order, at most 32.
    first_id : int
        Id of the first track; those of later ones ascend from it.

    Raises
    ------
    ValueError
        If there are too many cameras or a name occurs twice.

    """
    return fusion_method(config).open(config, cameras, first_id)


def open_batcher(config: FusionConfig, cameras: tuple[str, ...]) -> Batcher[Any]:
    """Return what sorts the cameras' messages into the ticks of a tracker; see `Batcher`."""
    return Batcher(config, cameras, fusion_method(config).unusable)


def open_recorder(config: FusionConfig) -> DecisionRecorder | None:
    """Return what takes down why the next tick is decided as it is; None: nobody can say."""
    recorder = fusion_method(config).recorder
    return None if recorder is None else recorder()
