"""Fusion of a sequence of ticks from any source."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from mctrack_ros.fusion import DecisionRecorder, FusionConfig, FusionOutput, FusionPipeline
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.interfaces import Explanation, Feedback, Tick


@dataclass(frozen=True, eq=False, slots=True)
class TickOutput:
    """
    Input and output of fusion for one tick.

    Attributes
    ----------
    tick : Tick
        The input.
    output : FusionOutput
        Tracks and events.
    feedback : Feedback
        Predictions for the cameras.
    explanation : Explanation, optional
        Why fusion decided so, if that was asked.
    bias : CameraBias
        How the cameras disagree, in the site's order; updated in place by the next tick.

    """

    tick: Tick
    output: FusionOutput
    feedback: Feedback
    explanation: Explanation | None
    bias: CameraBias


def drive(
    config: FusionConfig,
    cameras: tuple[str, ...],
    ticks: Iterable[Tick],
    is_asked_why: Callable[[Tick], bool] = lambda tick: False,
) -> Iterator[TickOutput]:
    """
    Step a new fusion pipeline over ticks.

    Parameters
    ----------
    config : FusionConfig
        Parameters.
    cameras : tuple of str
        Names in the site's order.
    ticks : iterable of Tick
        As `FusionPipeline.step` takes them. Each is taken only after the caller has dealt with
        the output of the one before: a generator can use the feedback of all earlier ticks.
    is_asked_why : callable
        Whether a tick is explained.

    Yields
    ------
    TickOutput
        One a tick, in order.

    Raises
    ------
    ValueError, OverflowError
        As `FusionPipeline` and its `step` do.

    """
    pipeline = FusionPipeline(config, cameras)
    for tick in ticks:
        recorder = DecisionRecorder() if is_asked_why(tick) else None
        output = pipeline.step(tick, recorder)
        explanation = recorder.explanation if recorder else None
        yield TickOutput(tick, output, pipeline.feedback(), explanation, pipeline.bias)
