"""The silhouettes paper's Table 1 on the simulated car park: what was tracked of what went on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.workers import Progress, run_spread, silent
from mctrack_experiments.papers.silhouettes.activity import ActivityTable, wilson_interval
from mctrack_experiments.papers.silhouettes.carpark_truth import Operator
from mctrack_experiments.papers.silhouettes.perceived import (
    PerceivedEvent,
    Sightings,
    activity_table,
    perceived_events,
)
from mctrack_ros.codec import compressed_message, image_from_message, jpeg_from_image
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception.silhouettes import (
    SilhouetteCameraConfig,
    SilhouetteConfig,
    SilhouettePipeline,
    as_printed,
)
from mctrack_ros.recording import ROSBAGS_CLASSES
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import CARPARK, CarParkScenario, CarParkWorld, Scenario
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.site import load_site

DURATION_S = 600.0

_KINDS = {'pedestrians': ClassCode.PERSON, 'vehicles': ClassCode.VEHICLE}


@dataclass(frozen=True, eq=False, slots=True)
class Watched:
    """
    One recording as an operator and as a tracker perceived it.

    Attributes
    ----------
    events : dict of str to list of PerceivedEvent
        Of pedestrians and of vehicles.
    passed_on : frozenset of int
        Tracks that were passed on to a classifier of behaviour.

    """

    events: dict[str, list[PerceivedEvent]]
    passed_on: frozenset[int]

    def table(self, kind: str) -> ActivityTable:
        """Return the table of one class."""
        return activity_table(self.events[kind])

    @property
    def flagged(self) -> int:
        """Number of perfect pedestrian events of which every subject was passed on, by flag."""
        return sum(
            event.counted == len(event.subjects) and set(event.tracks) <= self.passed_on
            for event in self.events['pedestrians']
            if event.subjects
        )


def reproduce_silhouettes(
    seeds: Sequence[int], progress: Progress = silent, duration_s: float = DURATION_S
) -> Figures:
    """
    Track recordings of the car park by silhouettes and fill the paper's table.

    Once with the parameters here, and once with those that the paper prints.

    Parameters
    ----------
    seeds : sequence of int
        One recording each.
    progress : callable
        Told how many are done, of how many.
    duration_s : float
        Length of each, s.

    """
    scenarios = [CarParkScenario(seed=seed, duration_s=duration_s) for seed in seeds]
    recordings = run_spread(watched, scenarios, progress)
    protocol = _protocol(seeds, duration_s)
    figures: dict[str, float] = {}
    for prefix, (words, _) in _TRACKERS.items():
        own = [one[prefix] for one in recordings]
        tables = {
            kind: sum((one.table(kind) for one in own), ActivityTable.of([])) for kind in _KINDS
        }
        protocol |= {
            f'{words}, {kind}: true number down, tracked number across': f'\n{table.text()}'
            for kind, table in tables.items()
        }
        found = _figures(tables, sum(one.flagged for one in own))
        figures |= {f'{prefix}{name}': value for name, value in found.items()}
    return Figures('silhouettes', 'mctrack reproduce silhouettes', protocol, figures)


def watched(scenario: Scenario) -> dict[str, Watched]:
    """Render and track one recording; return what each tracker perceived."""
    cv2.setNumThreads(1)
    world = CARPARK.world(scenario)
    assert isinstance(world, CarParkWorld)
    operator, mapping = Operator(world), _camera().mapping()
    trackers = {
        prefix: (SilhouettePipeline(config(), mapping), _TrackLog())
        for prefix, (_, config) in _TRACKERS.items()
    }
    renderer = CARPARK.renderer(world, 0)
    for step in range(scenario.steps):
        image, view = renderer.frame(step)
        operator.watch(step, view)
        stamp_ns = scenario.stamp_ns(step)
        received = _received(image, stamp_ns)
        for pipeline, log in trackers.values():
            pipeline.step(received, stamp_ns, None)
            log.add(step, pipeline)
    return {
        prefix: _watched(operator, log, scenario.period_s) for prefix, (_, log) in trackers.items()
    }


def _watched(operator: Operator, log: _TrackLog, period_s: float) -> Watched:
    events = {}
    for name, kind in _KINDS.items():
        shown, hidden = operator.perceived(kind)
        together = operator.together if kind == ClassCode.PERSON else np.empty((0, 2), np.int64)
        tracks = log.sightings(kind)
        events[name] = perceived_events(shown, together, tracks, period_s, hidden)
    return Watched(events, frozenset(log.passed_on))


class _TrackLog:
    """All established objects of a tracker, image by image."""

    def __init__(self) -> None:
        self._step: list[int] = []
        self._key: list[int] = []
        self._box: list[NDArray[np.float64]] = []
        self._class: list[int] = []
        self.passed_on: set[int] = set()

    def add(self, step: int, pipeline: SilhouettePipeline) -> None:
        """Note the objects after an image."""
        objects = pipeline.objects
        self.passed_on.update(objects.local_id[objects.passed_on].tolist())
        for row in np.flatnonzero(objects.established & objects.matched).tolist():
            self._step.append(step)
            self._key.append(int(objects.local_id[row]))
            self._box.append(objects.box[row])
            self._class.append(int(objects.class_id[row]))

    def sightings(self, kind: ClassCode) -> Sightings:
        """Return the tracks that were taken for a class in most of their images."""
        step, key = np.array(self._step, np.int64), np.array(self._key, np.int64)
        box = np.array(self._box, np.float64).reshape(-1, 4)
        of_kind = np.array(self._class, np.int64) == kind
        keys, index = np.unique(key, return_inverse=True)
        share = np.bincount(index, of_kind) / np.maximum(np.bincount(index), 1)
        majority = keys[share >= 0.5 if kind == ClassCode.PERSON else share > 0.5]
        return Sightings(step, key, box).of(majority)


def _received(image: NDArray[np.uint8], stamp_ns: int) -> NDArray[np.uint8]:
    """Return an image as it arrives from a bag: through JPEG."""
    jpeg = jpeg_from_image(image)
    return image_from_message(compressed_message(jpeg, ROSBAGS_CLASSES, stamp_ns, 'cam1'))


def _camera() -> CameraSettings:
    return load_site(config_file('carpark.yaml')).cameras['cam1']


def _shipped() -> SilhouetteConfig:
    """Return the parameters of the car park's site."""
    config = _camera().pipeline
    assert isinstance(config, SilhouetteCameraConfig)
    return config.silhouettes


_TRACKERS: Mapping[str, tuple[str, Callable[[], SilhouetteConfig]]] = {
    '': ('here', _shipped),
    'printed.': ('as printed', as_printed),
}
"""By the prefix of their figures: the parameters here, and those of the paper."""


def _protocol(seeds: Sequence[int], duration_s: float) -> dict[str, Any]:
    scenario = replace(CarParkScenario(), duration_s=duration_s)
    return {
        'scene': f'car park, {duration_s:g} s of {1 / scenario.period_s:g} images a second each',
        'seeds': ', '.join(str(seed) for seed in seeds)
        + ' (the tracker is tuned on 1 to 3, 31 and 101 to 103)',
        'event': 'people who touch at some time; those who came together count as one '
        '(assumption 3). A car each time it comes or leaves. Perceived for 3 s at least',
        'counted': 'established tracks of the class that are on the event; those on nothing are '
        'an event of row 0; a subject with no track in half of its images is lost',
        'printed': "the same recordings with the paper's own parameters and nothing beyond",
    }


def _figures(tables: dict[str, ActivityTable], flagged: int) -> dict[str, float]:
    people, cars = tables['pedestrians'], tables['vehicles']
    perfect, events = people.perfect + cars.perfect, people.events + cars.events
    passed, judged = people.passed
    figures: dict[str, float] = {
        'events.correct': perfect / max(events, 1),
        'events.perfect': perfect,
        'events.all': events,
        'events.low': wilson_interval(perfect, events)[0],
        'events.high': wilson_interval(perfect, events)[1],
        'pedestrians.passed': passed / max(judged, 1),
        'pedestrians.perfect': passed,
        'pedestrians.judged': judged,
        'pedestrians.low': wilson_interval(passed, judged)[0],
        'pedestrians.high': wilson_interval(passed, judged)[1],
        'pedestrians.flagged': flagged,
    }
    for kind, table in tables.items():
        figures |= {
            f'{kind}.events': table.events,
            f'{kind}.correct': table.perfect / max(table.events, 1),
            f'{kind}.over_tracked': table.over_tracked,
            f'{kind}.lost': table.lost,
            f'{kind}.false': table.false,
        }
    return figures
