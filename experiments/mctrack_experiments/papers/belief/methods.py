"""Belief propagation and the paper's baselines on the images of a scene, started by hand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.papers.belief.condensation import Condensation, best_view, central
from mctrack_experiments.papers.belief.scenes import OcclusionScene
from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.ground import GroundBelief
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Belief
from mctrack_ros.perception.belief.config import BeliefCameraConfig
from mctrack_ros.perception.belief.view import ViewFilters
from mctrack_ros.simulation import Camera
from mctrack_ros.tracking.particles import normalised

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

START_M = 0.1
"""Standard deviation of where targets are given by hand, m."""
WHOLE = 0.95
"""Share of a person that must be visible for his colours to be learned by hand."""
LOST_M, GIVEN_S = 1.0, 1.0
"""A method that is farther from a target so long before an occlusion is given him anew."""


class Instant(NamedTuple):
    """Images of all cameras, their true calibrations, and homographies from the images before."""

    stamp_ns: int
    images: Mapping[str, Image]
    mappings: Mapping[str, ProjectiveMapping]
    motions: Mapping[str, Floats | None]


class Propagation:
    """Belief propagation: the view filters and the ground node, without the nodes around them."""

    def __init__(self, first: Mapping[str, ProjectiveMapping], stamp_ns: int) -> None:
        self.ground = GroundBelief(BeliefConfig())
        self.ground.stamp_ns = stamp_ns
        self.filters = {
            name: ViewFilters(mapping, name, BeliefCameraConfig())
            for name, mapping in first.items()
        }
        self.entropy: dict[int, Floats] = {}

    def give(self, target: int, place: Floats) -> None:
        """Start a target anew at a place, (2,) m."""
        self.ground.end([target])
        self.ground.start(target, place, START_M**2 * np.eye(2))

    def step(self, now: Instant) -> dict[int, Floats]:
        """Process the images of an instant; return where targets are, (2,) m, by id."""
        feedback, ids = self.ground.belief(), list(self.ground.targets)
        said = {}
        for name, filters in self.filters.items():
            filters.mapping = now.mappings[name]
            said[name] = filters.step(now.images[name], now.stamp_ns, feedback, now.motions[name])
        self.ground.step(said, now.stamp_ns)
        self.entropy = {}
        if self.ground.last is not None and len(self.ground.last.to_ground) == len(said):
            weight = normalised(self.ground.last.to_ground)
            entropy = -(weight * np.log(np.maximum(weight, 1e-300))).sum(axis=2)
            self.entropy = dict(zip(ids, entropy.T))
        return {
            key: target.state[:, :2].mean(axis=0) for key, target in self.ground.targets.items()
        }


class Alone:
    """Condensation in each view, its mean place by view, and what is made of both views."""

    def __init__(self, first: Mapping[str, ProjectiveMapping], start: Belief) -> None:
        config = BeliefCameraConfig()
        self.filters = {
            name: Condensation(mapping, name, config, start) for name, mapping in first.items()
        }

    def step(self, now: Instant) -> dict[str, Floats]:
        """Process the images of an instant; return places, (t, 2) m, by view and of both."""
        told = {
            name: each.step(now.images[name], now.stamp_ns, now.mappings[name], now.motions[name])
            for name, each in self.filters.items()
        }
        estimates = list(told.values())
        found = {name: each.mean for name, each in told.items()}
        return found | {'central': central(estimates), 'best_view': best_view(estimates)}


class Methods:
    """
    All methods on one scene, step by step.

    Parameters
    ----------
    scene : OcclusionScene
        The scene.

    Attributes
    ----------
    belief : Propagation
        Belief propagation.
    alone : Alone
        The baselines.
    tracks : dict of str to (steps, t, 2) array
        Places by method, m, up to now; NaN: none. The views' names: Condensation there.
    entropy : (steps, cameras, t) array
        Of the messages to the ground; NaN: of a silent view.

    """

    def __init__(self, scene: OcclusionScene) -> None:
        scenario, self._truth = scene.world.scenario, scene.truth
        self._scene, (steps, count) = scene, scene.truth.shape[:2]
        first = {camera.name: mapping_of(camera) for camera in scene.world.views(0)}
        self.belief = Propagation(first, scenario.stamp_ns(0) - round(scenario.period_s * 1e9))
        for target in range(count):
            self.belief.give(target + 1, scene.truth[0, target])
        self.alone = Alone(first, self.belief.ground.belief())
        self._learn()
        names = ('belief', *first, 'central', 'best_view')
        names = ('belief', *first, 'central', 'best_view')
        self.tracks = {name: np.full(scene.truth.shape, np.nan) for name in names}
        self.entropy = np.full((steps, len(first), count), np.nan)

    def _learn(self) -> None:
        """Show all methods the targets' colours in the first images that show them whole."""
        scene, wanted = self._scene, dict[tuple[int, int], list[int]]()
        for camera, target in np.ndindex(scene.visible.shape[1:]):
            step = int(np.argmax(scene.visible[:, camera, target] >= WHOLE))
            wanted.setdefault((camera, step), []).append(target)
        names = list(self.belief.filters)
        for (camera, step), targets in wanted.items():
            image, view = scene.renderers[camera].frame(step)
            rows = [view.person.tolist().index(scene.persons[target]) for target in targets]
            for filters in (self.belief.filters, self.alone.filters):
                ids = [target + 1 for target in targets]
                filters[names[camera]].learn(image, ids, view.box[rows])

    def steps(self) -> Iterator[tuple[int, Instant]]:
        """Yield each step and its images after all methods have processed them."""
        scenario = self._scene.world.scenario
        before: Mapping[str, ProjectiveMapping] = {}
        for step, (cameras, images) in enumerate(self._scene.frames()):
            mappings = {name: mapping_of(camera) for name, camera in cameras.items()}
            motions = {
                name: _motion(before.get(name, mapping), mapping)
                for name, mapping in mappings.items()
            }
            now = Instant(scenario.stamp_ns(step), images, mappings, motions)
            self._give_lost(step)
            for target, place in self.belief.step(now).items():
                self.tracks['belief'][step, target - 1] = place
            for target, entropy in self.belief.entropy.items():
                self.entropy[step, :, target - 1] = entropy
            for name, places in self.alone.step(now).items():
                self.tracks[name][step] = places
            before = mappings
            yield step, now

    def _give_lost(self, step: int) -> None:
        """Give the filters whom they have lost, where an occlusion is near."""
        scene = self._scene
        before = round(GIVEN_S * scene.world.scenario.rate_hz)
        for occlusion in scene.occlusions:
            if step == 0 or step != max(scene.hidden(occlusion)[0] - before, 1):
                continue
            target, place = occlusion.target, self._truth[step - 1, occlusion.target]
            for name in ('belief', *self.alone.filters):
                gap = np.linalg.norm(self.tracks[name][step - 1, target] - place)
                if gap <= LOST_M:
                    continue
                if name == 'belief':
                    self.belief.give(target + 1, place)
                else:
                    self.alone.filters[name].give(self._by_hand(target, place))

    def _by_hand(self, target: int, place: Floats) -> Belief:
        """Return ground particles of a target at a place."""
        ground = GroundBelief(BeliefConfig())
        ground.stamp_ns = self.belief.ground.stamp_ns
        ground.start(target + 1, place, START_M**2 * np.eye(2))
        return ground.belief()


def mapping_of(camera: Camera) -> ProjectiveMapping:
    """Return the true calibration of a camera."""
    return ProjectiveMapping(camera.matrix, camera.size)


def _motion(before: ProjectiveMapping, now: ProjectiveMapping) -> Floats | None:
    """Return the homography between two images of a camera; None: it stood still."""
    old, new = (each.image_from_ground_homography for each in (before, now))
    return None if np.array_equal(old, new) else np.asarray(new @ np.linalg.inv(old))
