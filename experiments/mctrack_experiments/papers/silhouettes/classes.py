"""People, bicycles and vehicles of the simulated car park, told apart by the default tracker."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from scipy.optimize import linear_sum_assignment

from mctrack_experiments.bench.workers import Progress, run_spread, silent
from mctrack_experiments.papers.silhouettes.activity import wilson_interval
from mctrack_ros.config import config_from
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import ClassCode
from mctrack_ros.perception import EventTracker, EventTrackerConfig
from mctrack_ros.perception.blobs.extraction import iou
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import CARPARK, CarParkScenario, CarParkWorld
from mctrack_ros.site.site import load_site

DURATION_S = 600.0
RATE_HZ = 12.5

CLEAR, OVERLAP = 0.6, 0.3
"""Somebody counts in an image with so much visible; so much is shared by boxes of one."""

KINDS = {
    'people': ClassCode.PERSON,
    'bicycles': ClassCode.BICYCLE,
    'vehicles': ClassCode.VEHICLE,
}


@dataclass(eq=False, slots=True)
class Told:
    """
    What was told of one who came.

    Attributes
    ----------
    kind : ClassCode
        What it is.
    shown : int
        Images in which it is clear.
    classes : Counter of int
        What it was taken for in those of them where it was found.
    local_ids : set of int
        Local ids that it had there.
    errors_m : list of float
        How far from its place it was found, m.

    """

    kind: ClassCode
    shown: int = 0
    classes: Counter[int] = field(default_factory=Counter)
    local_ids: set[int] = field(default_factory=set)
    errors_m: list[float] = field(default_factory=list)

    @property
    def usually(self) -> int:
        """What it was taken for most often; 0: it never was told."""
        reported = Counter({kind: count for kind, count in self.classes.items() if kind})
        return reported.most_common(1)[0][0] if reported else 0


def reproduce_classes(
    seeds: Sequence[int], progress: Progress = silent, duration_s: float = DURATION_S
) -> Figures:
    """
    Track recordings of the car park and count what was taken for what.

    Parameters
    ----------
    seeds : sequence of int
        One recording each.
    progress : callable
        Told how many are done, of how many.
    duration_s : float
        Length of each, s.

    """
    scenarios = [
        CarParkScenario(seed=seed, duration_s=duration_s, rate_hz=RATE_HZ, bicycles=True)
        for seed in seeds
    ]
    everybody = [one for came in run_spread(watched, scenarios, progress) for one in came]
    figures: dict[str, float] = {}
    for name, kind in KINDS.items():
        figures |= _figures(name, [one for one in everybody if one.kind == kind])
    return Figures(
        name='classes',
        command='mctrack reproduce classes',
        protocol={
            'scene': f'car park with bicycles, one camera, {duration_s:g} s of {RATE_HZ:g} '
            'images a second each',
            'seeds': f'{", ".join(map(str, seeds))}; the tracker is tuned on 1 to 3',
            'tracker': 'the default one, with tracker.vehicles',
            'counted': f'who comes, and what is not parked, where {CLEAR:g} of it is visible and '
            'the edge of the image cuts nothing off',
            'found': f'share of the images in which a box overlaps by {OVERLAP:g} '
            '(intersection over union, one to one)',
            'right': 'share of those who were found that were taken for what they are most of the '
            'time; low, high: 95 % interval (Wilson)',
            'local_ids': 'of each of those, mean',
        },
        figures=figures,
    )


def watched(scenario: CarParkScenario) -> list[Told]:
    """Render and track one recording; return what was told of whom."""
    cv2.setNumThreads(1)
    world = CARPARK.world(scenario)
    assert isinstance(world, CarParkWorld)
    config = config_from(EventTrackerConfig, {'tracker': {'vehicles': True}})
    camera = load_site(config_file('carpark.yaml')).cameras['cam1']
    pipeline = EventTracker(config, camera.mapping())
    renderer = CARPARK.renderer(world, 0)
    everybody = [Told(ClassCode(kind)) for kind in world.class_id.tolist()]
    for step in range(scenario.steps):
        image, view = renderer.frame(step)
        grey = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
        found = pipeline.step(np.asarray(grey, np.uint8), scenario.stamp_ns(step), None).detections
        counts = world.active[step, view.person] & (view.visible >= CLEAR) & ~view.truncated
        for index in view.person[counts].tolist():
            everybody[index].shown += 1
        shared = iou(view.box.astype(np.float64), found.box.astype(np.float64))
        for row, column in zip(*linear_sum_assignment(-shared)):
            if counts[row] and shared[row, column] >= OVERLAP:
                own = everybody[view.person[row]]
                own.classes[int(found.class_id[column])] += 1
                own.local_ids.add(int(found.local_id[column]))
                place = world.motion.position[step, view.person[row]]
                own.errors_m.append(float(np.linalg.norm(found.position[column, :2] - place)))
    return everybody


def _figures(name: str, came: list[Told]) -> dict[str, float]:
    """Return the figures of one kind."""
    shown, found = sum(one.shown for one in came), sum(one.classes.total() for one in came)
    reported = [one for one in came if one.usually]
    right = sum(one.usually == one.kind for one in reported)
    low, high = wilson_interval(right, len(reported))
    errors_m = [error for one in came for error in one.errors_m]
    return {
        f'{name}.number': sum(one.shown > 0 for one in came),
        f'{name}.found': found / max(shown, 1),
        f'{name}.told': len(reported),
        f'{name}.right': right / max(len(reported), 1),
        f'{name}.low': low,
        f'{name}.high': high,
        f'{name}.local_ids': float(np.mean([len(one.local_ids) for one in reported])),
        f'{name}.error_median_m': float(np.median(errors_m)),
    }
