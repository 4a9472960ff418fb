"""Fusion of a sequence of ticks from any source."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from mctrack_ros.fusion import (
    FusionConfig,
    FusionOutput,
    OpenViews,
    Startable,
    open_fusion,
    open_recorder,
)
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.fusion.trackers import no_views
from mctrack_ros.interfaces import Detections, Explanation, Rows, RowsTick
from mctrack_ros.zones.engine import ZoneEngine
from mctrack_ros.zones.shapes import Zones


@dataclass(frozen=True, eq=False, slots=True)
class TickOutput:
    """
    Input and output of fusion for one tick.

    Attributes
    ----------
    tick : RowsTick
        The input.
    output : FusionOutput
        Tracks and events.
    feedback : Rows
        Predictions for the cameras.
    explanation : Explanation, optional
        Why fusion decided so, if that was asked.
    bias : CameraBias, optional
        How the cameras disagree, in the site's order, if that is estimated; updated in place by
        the next tick.

    """

    tick: RowsTick[Any]
    output: FusionOutput
    feedback: Rows
    explanation: Explanation | None
    bias: CameraBias | None


def drive(
    config: FusionConfig,
    cameras: tuple[str, ...],
    ticks: Iterable[RowsTick[Any]],
    is_asked_why: Callable[[RowsTick[Any]], bool] = lambda tick: False,
    views: OpenViews = no_views,
    starts: Iterable[Detections] = (),
    zones: Zones | None = None,
) -> Iterator[TickOutput]:
    """
    Step a new tracker over ticks.

    Parameters
    ----------
    config : FusionConfig
        Parameters.
    cameras : tuple of str
        Names in the site's order.
    ticks : iterable of RowsTick
        As the tracker's `step` takes them. Each is taken only after the caller has dealt with
        the output of the one before: a generator can use the feedback of all earlier ticks.
    is_asked_why : callable
        Whether a tick is explained.
    views : callable
        Reads how the cameras see the ground, if the tracker has to know.
    starts : iterable of Detections
        Tracks that are started and ended from outside; see `Startable`. Others do without.
    zones : Zones, optional
        Whose events are added to those of fusion, in the coordinates of the tracks.

    Yields
    ------
    TickOutput
        One a tick, in order.

    Raises
    ------
    ConfigError, CalibrationError, ValueError, OverflowError
        As the tracker's making and its `step` do.

    """
    tracker = open_fusion(config, cameras, views=views)
    if isinstance(tracker, Startable):
        for rows in starts:
            tracker.start(rows)
    engine = ZoneEngine(zones or Zones())
    for tick in ticks:
        recorder = open_recorder(config) if is_asked_why(tick) else None
        output = tracker.step(tick, recorder)
        output = replace(output, events=engine.added(output.tracks, output.events))
        explanation = recorder.explanation if recorder else None
        yield TickOutput(tick, output, tracker.feedback(), explanation, tracker.bias)
