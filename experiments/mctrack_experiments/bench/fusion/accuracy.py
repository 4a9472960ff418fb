"""How right fusion is on whole scenes, paired with norfair on the same detections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_experiments.bench.fusion.adapter import CoreTracker
from mctrack_experiments.bench.fusion.toolkit import Toolkit
from mctrack_experiments.bench.fusion.true_association import TrueAssociation
from mctrack_experiments.bench.workers import Progress, run_spread, silent

KINDS: Mapping[str, Mapping[str, float]] = {'base': {}, 'crowd': {'density': 4.0}}
FRAMES = 1000
PEER = 'norfair'
MEASURES = {
    'mota': 'mota',
    'idf1': 'idf1',
    'switches': 'switches',
    'misses': 'misses',
    'false_positives': 'false_positives',
    'position_error_m': 'motp',
}
"""Names of the figures and what the scorer calls them."""

RANGED = ('mota', 'idf1', 'switches')
"""Those whose least and most are given beside the mean."""

Scores = Mapping[str, Mapping[str, float]]


def measure_accuracy(
    folder: Path,
    peers: Sequence[str],
    seeds: Sequence[int],
    frames: int = FRAMES,
    progress: Progress = silent,
) -> dict[str, float]:
    """
    Score whole scenes of both kinds.

    Parameters
    ----------
    folder : Path
        Of the benchmark.
    peers : sequence of str
        Other trackers that may be run.
    seeds : sequence of int
        One scene of each kind for each.
    frames : int
        Ticks of a scene.
    progress : callable
        Told how many scenes are done.

    """
    jobs = [(folder, kind, seed, frames, PEER in peers) for kind in KINDS for seed in seeds]
    scores = run_spread(_scored, jobs, progress)
    figures: dict[str, float] = {}
    for kind in KINDS:
        chosen = [score for job, score in zip(jobs, scores) if job[1] == kind]
        figures |= {f'{kind}.{name}': value for name, value in summary(chosen).items()}
    return figures


def _scored(job: tuple[Path, str, int, int, bool]) -> Scores:
    """Return the measures of each tracker on one scene."""
    folder, kind, seed, frames, with_peer = job
    toolkit = Toolkit(folder)
    scene = toolkit.scene(frames, seed, **KINDS[kind])
    trackers: dict[str, Any] = {'fusion': CoreTracker(scene.scenario)}
    trackers['true_association'] = TrueAssociation(scene)
    if with_peer:
        trackers[PEER] = toolkit.peer(PEER, scene)
    measured = toolkit.measure(trackers, frames)
    scores = {name: toolkit.score(scene, each.reported) for name, each in measured.items()}
    return {
        tracker: {name: float(getattr(score, word)) for name, word in MEASURES.items()}
        for tracker, score in scores.items()
    }


def summary(scores: Sequence[Scores]) -> dict[str, float]:
    """
    Return means and ranges over scenes, and what fusion gains on its peer scene by scene.

    Parameters
    ----------
    scores : sequence of mapping
        Of each scene: by tracker, then by measure. ``fusion`` and ``true_association`` are in all.

    """
    ours = _columns(scores, 'fusion')
    true_error = _columns(scores, 'true_association')['position_error_m']
    figures = _spread('', ours)
    figures['position_error_ratio'] = float(np.mean(ours['position_error_m'] / true_error))
    figures['true_association.position_error_m'] = float(true_error.mean())
    if PEER in scores[0]:
        theirs = _columns(scores, PEER)
        figures |= _spread(f'{PEER}.', theirs)
        gain = {name: ours[name] - theirs[name] for name in RANGED}
        figures |= _spread('over_norfair.', gain)
    return figures


def _columns(scores: Sequence[Scores], tracker: str) -> dict[str, np.ndarray[Any, Any]]:
    """Return a tracker's measures, one value a scene."""
    return {name: np.array([score[tracker][name] for score in scores]) for name in MEASURES}


def _spread(label: str, columns: Mapping[str, np.ndarray[Any, Any]]) -> dict[str, float]:
    """Return the mean of each measure, and least and most of some."""
    figures: dict[str, float] = {}
    for name, values in columns.items():
        figures[f'{label}{name}'] = float(values.mean())
        if name in RANGED:
            figures[f'{label}{name}_least'] = float(values.min())
            figures[f'{label}{name}_most'] = float(values.max())
    return figures
