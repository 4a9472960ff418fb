"""A scene through the real fusion, and who had which id when."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.fusion.adapter import Reported, camera_names, reported
from mctrack_experiments.bench.fusion.synthetic_cameras import KITS, SyntheticCameras
from mctrack_experiments.scenarios.staged.stage import TICK_S, Stage, scene_of
from mctrack_ros.evaluation.frames import ground_distance, matched
from mctrack_ros.fusion import FusionOutput, JointConfig
from mctrack_ros.interfaces import (
    CameraDetections,
    Detections,
    EventCode,
    Feedback,
    Tick,
)
from mctrack_ros.replay.drive import drive

Floats = NDArray[np.float64]

FEEDBACK_DELAY = 2
"""Ticks, as in the nodes."""
TEMPLATE_PIXELS = 600.0
"""Chosen by what `galleries` takes for the usual variance of a template, not measured."""
GATE_M = 1.0
"""A track stands for nobody who is farther away, m."""


class Haunting(Protocol):
    """What stands between fusion and the cameras."""

    def told(self, tick: int, feedback: Feedback) -> Feedback:
        """Return what the cameras are told in a tick."""

    def seen(
        self, messages: Sequence[CameraDetections], feedback: Feedback
    ) -> Sequence[CameraDetections]:
        """Return what they detect, having been told."""


@dataclass(frozen=True, eq=False, slots=True)
class Played:
    """
    What fusion made of a scene.

    Attributes
    ----------
    paths : (ticks, people, 2) array
        Where everybody truly was, m.
    outputs : sequence of FusionOutput
        One a tick.

    """

    paths: Floats
    outputs: Sequence[FusionOutput]

    def reported(self, tick: int) -> Reported:
        """Return the ids and (n, 2) positions that are stood for at a tick."""
        return reported(self.outputs[tick].tracks)

    def matched(self, tick: int) -> list[tuple[int, int]]:
        """Return the people who have a track at a tick, each with its id."""
        names, places = self.reported(tick)
        people, rows = matched(ground_distance(self.paths[tick], places), GATE_M)
        return [(person, names[row]) for person, row in zip(people.tolist(), rows.tolist())]

    def ids(self, start_s: float, end_s: float) -> list[int]:
        """Return the id that each person has most often in a time; 0: none."""
        counts: list[Counter[int]] = [Counter() for _ in self.paths[0]]
        for tick in range(round(start_s / TICK_S), round(end_s / TICK_S)):
            for person, name in self.matched(tick):
                counts[person][name] += 1
        return [max(sorted(count), key=count.__getitem__, default=0) for count in counts]

    def corrections(self, start_s: float = 0.0) -> list[tuple[int, int]]:
        """Return the (old, new) ids of all corrections that were published from a time on."""
        found = []
        for output in self.outputs[round(start_s / TICK_S) :]:
            rows = output.events.event == EventCode.CORRECTION
            old, new = output.events.old_id[rows], output.events.new_id[rows]
            found += list(zip(old.tolist(), new.tolist()))
        return found


def keeps(before: Sequence[int], after: Sequence[int]) -> bool:
    """Tell whether everybody had an id of his own and has it still."""
    return 0 not in before and len(set(before)) == len(before) and list(before) == list(after)


def play(
    stage: Stage,
    seed: int,
    config: JointConfig | None = None,
    places_only: bool = False,
    haunting: Haunting | None = None,
) -> Played:
    """
    Let the cameras' detections go through the real fusion, and its feedback back to the cameras.

    Parameters
    ----------
    stage : Stage
        The scene.
    seed : int
        Of noise, misses and colours.
    config : JointConfig, optional
        Unless given, fusion as it comes.
    places_only : bool
        Cameras tell places alone: no colours, no ids, no groups.
    haunting : Haunting, optional
        Changes what the cameras are told, and what they see then.

    """
    scene = scene_of(stage, np.random.default_rng([seed, 2]))
    kit = np.append(stage.kit, KITS - 1)
    cameras = SyntheticCameras(scene, seed, kit, stage.personal, TEMPLATE_PIXELS)
    on_its_way = deque([Feedback.build(0)] * FEEDBACK_DELAY, FEEDBACK_DELAY)

    def ticks() -> Iterator[Tick]:
        for tick in range(len(stage.paths)):
            messages: Sequence[CameraDetections] = cameras.messages(tick, on_its_way[0])
            if places_only:
                messages = [_places(message) for message in messages]
            yield Tick.of(haunting.seen(messages, on_its_way[0]) if haunting else messages)

    outputs = []
    config = _timed(config or JointConfig())
    for tick, ticked in enumerate(drive(config, camera_names(scene.scenario), ticks())):
        outputs.append(ticked.output)
        feedback = ticked.feedback
        assert isinstance(feedback, Feedback)
        on_its_way.append(haunting.told(tick, feedback) if haunting else feedback)
    return Played(stage.paths, outputs)


def _places(message: CameraDetections) -> CameraDetections:
    rows = message.rows
    bare = Detections.build(rows.stamp_ns, position=rows.position, covariance=rows.covariance)
    return CameraDetections(message.camera, bare)


def _timed(config: JointConfig) -> JointConfig:
    return replace(config, batching=replace(config.batching, period=TICK_S))
