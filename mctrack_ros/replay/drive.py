"""Fusion over ticks, one after another, wherever they come from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from mctrack_ros.fusion import DecisionRecorder, FusionConfig, FusionOutput, FusionPipeline
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.interfaces import Explanation, Feedback, Tick


@dataclass(frozen=True, eq=False, slots=True)
class TickOutput:
    """
    Everything that came of one tick.

    Attributes
    ----------
    tick : Tick
        What fusion was given.
    output : FusionOutput
        What fusion made of it.
    feedback : Feedback
        What it tells the cameras.
    explanation : Explanation, optional
        Why, if that was asked.
    bias : CameraBias
        How the cameras disagree, in the site's order; it goes on changing with the next tick.

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
    Take ticks through a new fusion pipeline.

    Parameters
    ----------
    config : FusionConfig
        Parameters.
    cameras : tuple of str
        Names in the site's order.
    ticks : iterable of Tick
        As `FusionPipeline.step` takes them. None is taken before the last one's output has been
        dealt with: a generator can use the feedback of all before.
    is_asked_why : callable
        Tells for which ticks it is taken down why fusion decides as it does.

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
