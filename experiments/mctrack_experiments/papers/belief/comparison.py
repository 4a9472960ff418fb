"""Belief propagation beside the paper's baselines and the default tracker."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.workers import Progress, run_spread, silent
from mctrack_experiments.datasets.kloppy_motion import has_kloppy
from mctrack_experiments.papers.belief.crossings import crossing_figures
from mctrack_experiments.papers.belief.drawing import draw_figures
from mctrack_experiments.papers.belief.methods import GIVEN_S, LOST_M, Methods
from mctrack_experiments.papers.belief.natural import AROUND_S, SECONDS, TURNS, natural
from mctrack_experiments.papers.belief.protocol import (
    AFTER_S,
    GATE_M,
    ONE_VIEW,
    Kept,
    compared,
    interval,
    kept,
    with_interval,
)
from mctrack_experiments.papers.belief.scenes import Kind, OcclusionScene, scripted
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagReader
from mctrack_ros.replay.track import track_bag
from mctrack_ros.resources import config_file
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.site import load_site

Floats = NDArray[np.float64]

BEFORE_S = 0.4
"""So long before an occlusion it is asked which track of the default tracker is the target's."""
DEFAULT_LEAD_S = 2.0


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


Job = tuple[str, int]
"""Static, ptz or real, and the seed; of real motion the turn."""


def reproduce_belief(
    data: Path, seeds: Sequence[int], progress: Progress = silent, image: Path | None = None
) -> Figures:
    """
    Compare the trackers on scripted matches, with real motion and on the terrace.

    Parameters
    ----------
    data : Path
        Folder of the real data, with the terrace.
    seeds : sequence of int
        One match each, before static cameras and before PTZ cameras.
    progress : callable
        Told how many are done, of how many.
    image : Path, optional
        Where to draw the paper's Figures 4 to 7 of the first seed: the stem gets their numbers.

    """
    jobs = [(kind, seed) for kind in ('static', 'ptz') for seed in seeds]
    if has_kloppy():
        jobs += [('real', turn) for turn in range(len(TURNS))]
    outcomes = run_spread(outcome_of, jobs, progress)
    by_kind = {
        kind: [each for job, each in zip(jobs, outcomes) if job[0] == kind]
        for kind in ('static', 'ptz', 'real')
    }
    figures = _figures(by_kind['static'])
    figures |= {f'ptz.{key}': each for key, each in _figures(by_kind['ptz']).items()}
    if by_kind['real']:
        figures |= {f'real.{key}': each for key, each in _pooled(by_kind['real']).items()}
    figures |= crossing_figures(data)
    if image is not None:
        for number, drawn in draw_figures(scripted(seeds[0])).items():
            cv2.imwrite(str(image.with_stem(f'{image.stem}_{number}')), drawn)
    return Figures('belief', 'mctrack reproduce belief', _protocol(seeds), figures)


def outcome_of(job: Job) -> Outcome:
    """Run all methods over one match."""
    kind, seed = job
    if kind == 'real':
        return played(natural(TURNS[seed]))
    scene = scripted(seed, moving=kind == 'ptz')
    outcome = played(scene)
    if kind == 'static':
        outcome.survived['default'] = kept_by_default(scene)
    return outcome


def played(scene: OcclusionScene) -> Outcome:
    """Run belief propagation and the baselines over a match, on the same images."""
    methods = Methods(scene)
    for _ in methods.steps():
        pass
    survived = {name: kept(scene, each) for name, each in methods.tracks.items()}
    both = [survived.pop(name) for name in methods.alone.filters]
    survived['condensation'] = {
        kind: np.concatenate([each[kind] for each in both]) for kind in Kind
    }
    return Outcome(survived, _entropies(scene, methods.entropy))


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


def _ids_near(tracks: Tracks | None, place: Floats) -> list[int]:
    """Return the ids within the gate of a place, nearest first."""
    if tracks is None:
        return []
    gap = np.linalg.norm(tracks.position[:, :2] - place, axis=1)
    order = np.argsort(gap)
    return list(tracks.track_id[order[gap[order] <= GATE_M]].tolist())


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


def _pooled(outcomes: Sequence[Outcome]) -> dict[str, float]:
    """Return the figures of occlusions that happened by themselves, all together."""
    figures: dict[str, float] = {}
    one = {
        name: np.concatenate([each.survived[name][Kind.ONE_VIEW] for each in outcomes])
        for name in outcomes[0].survived
    }
    figures['occlusions'] = float(len(one['belief']))
    for name, values in one.items():
        figures |= with_interval(f'{name}.kept', values.astype(np.float64))
        if name in ('central', 'best_view'):
            lead = one['belief'].astype(np.float64) - values
            figures |= with_interval(f'lead.{name}', lead)
    hidden, clear = np.concatenate([each.entropy for each in outcomes]).mean(axis=0)
    return figures | {'entropy.occluded': float(hidden), 'entropy.clear': float(clear)}


def _protocol(seeds: Sequence[int]) -> Mapping[str, object]:
    return {
        'scene': 'scripted match of 30 s at 25 Hz: five targets, each hidden four times, before '
        'two cameras; static, and turning and zooming with true calibrations (ptz)',
        'seeds': ', '.join(map(str, seeds)),
        'kept': f'within {GATE_M:g} m of the target {AFTER_S:g} s after the occlusion; means over '
        'occlusions in one view, 95 % intervals by bootstrap over seeds (real: over occlusions)',
        'started': 'by the true places at the first image, as the paper does by hand; whom a '
        f'filter has lost by more than {LOST_M:g} m is given it anew {GIVEN_S:g} s before each of '
        'his occlusions; colours are learned from the first image that shows a target whole',
        'condensation': 'each view alone, mean of both; central: their estimates weighed by '
        'covariance; best_view: of the view whose image is likelier. Particles, motion and '
        'likelihood are those of belief propagation',
        'default': 'joint tracker by background subtraction on the same images, started by '
        f'itself; kept: the track that is at the target {BEFORE_S:g} s before the occlusion is so '
        'after it',
        'real': f"{SECONDS:g} s of Hawk-Eye's sample in kloppy, as it is and mirrored, drive the "
        'players before the two static cameras; all occlusions in one view of at least 3 images '
        f'of players whom both see {AROUND_S:g} s before and after',
        'crossings': 'terrace, two videos, first half: two annotated people pass within 1 m of '
        'each other on the ground; kept: both have the same track before, and 1 s after',
    }
