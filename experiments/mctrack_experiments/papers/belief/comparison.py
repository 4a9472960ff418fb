"""Belief propagation beside the paper's baselines and the default tracker, on scripted matches."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.workers import Progress, run_spread, silent
from mctrack_experiments.papers.belief.condensation import Condensation, best_view, central
from mctrack_experiments.papers.belief.protocol import (
    AFTER_S,
    GATE_M,
    ONE_VIEW,
    Kept,
    compared,
    interval,
    kept,
)
from mctrack_experiments.papers.belief.scenes import Kind, OcclusionScene, scripted
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion.belief.config import BeliefConfig
from mctrack_ros.fusion.belief.ground import GroundBelief
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import Tracks
from mctrack_ros.perception.belief.config import BeliefCameraConfig
from mctrack_ros.perception.belief.view import ViewFilters
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.track import track_bag
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import Camera
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.site import load_site
from mctrack_ros.tracking.particles import normalised

Floats = NDArray[np.float64]

START_M = 0.1
"""Standard deviation of where targets are started by hand, m."""
BEFORE_S = 0.4
"""So long before an occlusion it is asked which track of the default tracker is the target's."""


class Outcome(NamedTuple):
    """
    What is measured on one match.

    Attributes
    ----------
    survived : dict of str to Kept
        By method.
    entropy : (k, 2) array
        Of the messages of the occluded and of the clear view, for each occlusion in one view.

    """

    survived: dict[str, Kept]
    entropy: Floats


def reproduce_belief(seeds: Sequence[int], progress: Progress = silent) -> Figures:
    """
    Compare the trackers on scripted matches before static cameras, and before PTZ cameras.

    Parameters
    ----------
    seeds : sequence of int
        One match each.
    progress : callable
        Told how many are done, of how many.

    """
    static = run_spread(_static, list(seeds), progress)
    panned = run_spread(_panned, list(seeds), progress)
    figures = _figures(static) | {f'ptz.{key}': each for key, each in _figures(panned).items()}
    protocol = {
        'scene': 'scripted match of 30 s at 25 Hz: five targets, each hidden four times, before '
        'two cameras; static, and turning and zooming with true calibrations (ptz)',
        'seeds': ', '.join(map(str, seeds)),
        'kept': f'within {GATE_M:g} m of the target {AFTER_S:g} s after the occlusion; means over '
        'occlusions in one view, 95 % intervals by bootstrap over seeds',
        'started': 'by the true places at the first image, as the paper does by hand',
        'condensation': 'each view alone, mean of both; central: their estimates weighed by '
        'covariance; best_view: of the view whose image is likelier. Particles, motion and '
        'likelihood are those of belief propagation',
        'default': 'joint tracker by background subtraction on the same images, started by '
        f'itself; kept: the track that is at the target {BEFORE_S:g} s before the occlusion is so '
        'after it',
    }
    return Figures('belief', 'mctrack reproduce belief', protocol, figures)


def _static(seed: int) -> Outcome:
    scene = scripted(seed)
    outcome = outcome_of(scene)
    outcome.survived['default'] = kept_by_default(scene)
    return outcome


def _panned(seed: int) -> Outcome:
    return outcome_of(scripted(seed, moving=True))


def outcome_of(scene: OcclusionScene) -> Outcome:
    """Run belief propagation and the baselines over a match, on the same images."""
    config, view = BeliefConfig(), BeliefCameraConfig()
    scenario, truth = scene.world.scenario, scene.truth
    ground = GroundBelief(config)
    ground.stamp_ns = scenario.stamp_ns(0) - round(scenario.period_s * 1e9)
    targets = truth.shape[1]
    for target in range(targets):
        ground.start(target + 1, truth[0, target], START_M**2 * np.eye(2))
    first = {camera.name: mapping_of(camera) for camera in scene.world.views(0)}
    views = {name: ViewFilters(mapping, name, view) for name, mapping in first.items()}
    alone = {
        name: Condensation(mapping, name, view, ground.belief()) for name, mapping in first.items()
    }
    names = ['belief', 'central', 'best_view', *alone]
    tracks = {name: np.full(truth.shape, np.nan) for name in names}
    entropy = np.full((len(truth), len(first), targets), np.nan)
    before = first
    for step, (cameras, images, _) in enumerate(scene.frames()):
        stamp_ns = scenario.stamp_ns(step)
        now = {name: mapping_of(camera) for name, camera in cameras.items()}
        feedback, said, estimates = ground.belief(), {}, []
        for name, filters in views.items():
            motion = _motion(before[name], now[name])
            filters.mapping = now[name]
            said[name] = filters.step(images[name], stamp_ns, feedback, motion)
            estimates.append(alone[name].step(images[name], stamp_ns, now[name], motion))
            tracks[name][step] = estimates[-1].mean
        ground.step(said, stamp_ns)
        for track_id, found in ground.targets.items():
            tracks['belief'][step, track_id - 1] = found.state[:, :2].mean(axis=0)
        tracks['central'][step], tracks['best_view'][step] = (
            central(estimates),
            best_view(estimates),
        )
        if ground.last is not None and ground.last.to_ground.shape[:2] == entropy.shape[1:]:
            weight = normalised(ground.last.to_ground)
            entropy[step] = -(weight * np.log(np.maximum(weight, 1e-300))).sum(axis=2)
        before = now
    survived = {name: kept(scene, each) for name, each in tracks.items()}
    both = [survived.pop(name) for name in alone]
    survived['condensation'] = {
        kind: np.concatenate([each[kind] for each in both]) for kind in Kind
    }
    return Outcome(survived, _entropies(scene, entropy))


def kept_by_default(scene: OcclusionScene) -> Kept:
    """Track the match with the default tracker and tell which occlusions its ids survive."""
    scenario = scene.world.scenario
    site = load_site(config_file('pitch5.yaml'))
    names = [camera.name for camera in scene.world.cameras]
    site = replace(site, cameras={name: site.cameras[name] for name in names})
    with tempfile.TemporaryDirectory(prefix='mctrack_belief_') as name:
        folder = Path(name)
        simulate(scenario, folder / 'bag', world=scene.world)
        track_bag(folder / 'bag', folder / 'out', site)
        with BagReader(folder / 'out' / 'bag') as bag:
            ticks = [rows for rows, _ in bag.rows('/tracks', Tracks)]
    step_of = [
        round((rows.stamp_ns - scenario.stamp_ns(0)) / (scenario.period_s * 1e9)) for rows in ticks
    ]
    by_step = dict(zip(step_of, ticks))
    before, after = round(BEFORE_S * scenario.rate_hz), round(AFTER_S * scenario.rate_hz)
    found: dict[Kind, list[bool]] = {kind: [] for kind in Kind}
    for occlusion in scene.occlusions:
        begin, end = scene.hidden(occlusion)
        ids = [
            _ids_near(by_step.get(step), scene.truth[step, occlusion.target])
            for step in (max(begin - before, 0), min(end - 1 + after, scenario.steps - 1))
        ]
        found[occlusion.kind].append(bool(ids[0][:1]) and ids[0][0] in ids[1])
    return {kind: np.array(values) for kind, values in found.items()}


def mapping_of(camera: Camera) -> ProjectiveMapping:
    """Return the true calibration of a camera."""
    return ProjectiveMapping(camera.matrix, camera.size)


def _ids_near(tracks: Tracks | None, place: Floats) -> list[int]:
    """Return the ids within the gate of a place, nearest first."""
    if tracks is None:
        return []
    gap = np.linalg.norm(tracks.position[:, :2] - place, axis=1)
    order = np.argsort(gap)
    return list(tracks.track_id[order[gap[order] <= GATE_M]].tolist())


def _motion(before: ProjectiveMapping, now: ProjectiveMapping) -> Floats | None:
    """Return the homography between two images of a camera; None: it stood still."""
    old, new = (each.image_from_ground_homography for each in (before, now))
    return None if np.array_equal(old, new) else np.asarray(new @ np.linalg.inv(old))


def _entropies(scene: OcclusionScene, entropy: Floats) -> Floats:
    """Return the mean entropies of both views' messages over each occlusion in one view."""
    pairs = []
    for occlusion in scene.occlusions:
        if occlusion.kind in ONE_VIEW:
            begin, end = scene.hidden(occlusion)
            (hidden,) = occlusion.cameras
            during = entropy[begin:end, [hidden, 1 - hidden], occlusion.target]
            if np.isfinite(during).any():
                pairs.append(np.nanmean(during, axis=0))
    return np.array(pairs).reshape(-1, 2)


def _figures(outcomes: Sequence[Outcome]) -> dict[str, float]:
    names = list(outcomes[0].survived)
    runs = {name: [each.survived[name] for each in outcomes] for name in names}
    figures = compared(runs, 'belief')
    hidden, clear = np.array([each.entropy.mean(axis=0) for each in outcomes]).T
    figures['entropy.occluded'], figures['entropy.clear'] = hidden.mean(), clear.mean()
    figures['entropy.lead'], figures['entropy.lead.low'], _ = interval(hidden - clear)
    return figures
