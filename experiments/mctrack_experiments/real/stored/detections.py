"""Fusion of real detections that others made: lab6p, CMC, PETS from six views, WILDTRACK."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.datasets.cmc import AREA as CMC_AREA
from mctrack_experiments.datasets.cmc import load_cmc
from mctrack_experiments.datasets.lab6p import load_lab6p
from mctrack_experiments.datasets.pets_multiview import (
    LEAST_SCORE,
    VIEWS,
    annotated,
    load_pets_multiview,
)
from mctrack_experiments.datasets.social_pose import ANKLE_M
from mctrack_experiments.datasets.stored import Floats, StoredScene, disturbed, inside
from mctrack_experiments.datasets.wildtrack import AREA as WILDTRACK_AREA
from mctrack_experiments.datasets.wildtrack import load_wildtrack, load_wildtrack_boxes
from mctrack_experiments.real.stored.tracking import track_stored
from mctrack_ros.evaluation import Scores, Trajectories, evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion.association.solvers import ASSOCIATORS
from mctrack_ros.perception.boxes import BodyModel

Settings = Mapping[str, float | str]

_STATED = 'defaults; stated are calibration, rate and what a detection means'
PETS_SPLIT = 398
"""First frame that is reported; body model and area were chosen on those before."""
AWAY_FRAMES = 14
"""Who was outside for longer, two seconds, is somebody new in the truth of PETS."""
SEEDS, DISTURBANCE_M = range(1, 9), 0.02
"""Of the runs that tell how much of a score is luck, and by how much detections are moved, m."""
WILDTRACK_SPLIT = 180
"""First frame of the second half."""
_LAB6P_KIND, _LAB6P_SIGMA_PX = 'proposed_confirmed', 2.0
_WILDTRACK_KIND, _WILDTRACK_SIGMA_PX, _BOX_SIGMA_PX = 'proposed_confirmed', 10.0, 2.0


@dataclass(frozen=True, eq=False, slots=True)
class StoredSet:
    """
    A data set whose detections others made, and how it is scored.

    Attributes
    ----------
    scene : StoredScene
        Detections and truth.
    gate_m : float
        Largest distance of a track from its person, m.
    counts : callable
        Tells which (n, 2) positions, m, of tracks lie where there is truth.
    first : int
        First frame that is scored.

    """

    scene: StoredScene
    gate_m: float
    counts: Callable[[Floats], NDArray[np.bool_]]
    first: int = 0

    def tracks(
        self, settings: Settings | None = None, cameras: tuple[str, ...] | None = None
    ) -> Trajectories:
        """Return the tracks, in frames and places that have truth."""
        tracks = track_stored(self.scene, settings or {}, cameras)
        tracks = tracks.at_frames(self.scene.truth.frame)
        return tracks.select(self.counts(tracks.position))

    def scores(self, tracks: Trajectories, gate_m: float | None = None) -> Scores:
        """Score tracks, by another gate if one is given."""
        return _from(self.first, self.scene.truth, tracks, gate_m or self.gate_m)

    def disturbed(self, seed: int) -> StoredSet:
        """Return the set with every detection moved a little."""
        return replace(self, scene=disturbed(self.scene, DISTURBANCE_M, seed))


def lab6p(data: Path) -> StoredSet:
    """Open EPFL's six people before four cameras."""
    scene = load_lab6p(data / 'epfl_lab6p', _LAB6P_KIND, _LAB6P_SIGMA_PX)
    return StoredSet(scene, 0.5, lambda position: np.ones(len(position), np.bool_))


def cmc(data: Path, sequence: int) -> StoredSet:
    """Open a sequence of CMC, people in a small room before four corner cameras."""
    scene = load_cmc(data / 'cmc_4cam', sequence, BodyModel())
    return StoredSet(scene, 1.0, partial(inside, area=CMC_AREA))


def pets_multiview(data: Path) -> StoredSet:
    """Open PETS 2009 S2.L1 from six views."""
    folder = data / 'pets2009_s2l1'
    scene = load_pets_multiview(folder, BodyModel())
    return StoredSet(scene, 1.0, partial(annotated, folder, truth=scene.truth), PETS_SPLIT)


def wildtrack(data: Path) -> StoredSet:
    """Open WILDTRACK's training split with OpenPose detections."""
    scene = load_wildtrack(data / 'wildtrack', _WILDTRACK_KIND, _WILDTRACK_SIGMA_PX)
    return StoredSet(scene, 1.0, partial(inside, area=WILDTRACK_AREA))


def wildtrack_boxes(data: Path) -> StoredSet:
    """Open the same with its annotated boxes for detections."""
    scene = load_wildtrack_boxes(data / 'wildtrack', _BOX_SIGMA_PX)
    return StoredSet(scene, 1.0, partial(inside, area=WILDTRACK_AREA))


DATA_SETS: Mapping[str, Callable[[Path], StoredSet]] = {
    'lab6p': lab6p,
    'cmc1': partial(cmc, sequence=1),
    'cmc2': partial(cmc, sequence=2),
    'pets': pets_multiview,
    'wildtrack': wildtrack,
    'wildtrack_boxes': wildtrack_boxes,
}
"""How to open each, by name."""


def reproduce_lab6p(data: Path) -> Figures:
    """Track EPFL's six people with four cameras, and with each camera alone."""
    each = lab6p(data)
    cameras = each.scene.cameras
    single = {camera: each.scores(each.tracks(cameras=(camera,))) for camera in cameras}
    best = max(single, key=lambda camera: single[camera].moda)
    figures = _figures('lab6p', each.scores(each.tracks()))
    figures |= _figures('lab6p.best_single', single[best])
    for camera, scores in single.items():
        figures[f'lab6p.{camera}.moda'] = scores.moda
    instants = set(each.scene.truth.frame.tolist())
    protocol = {
        'detections': f'Social-Pose, real OpenPose feet, {_LAB6P_KIND}; ankles {ANKLE_M:g} m up',
        'foot_sigma_px': _LAB6P_SIGMA_PX,
        'cameras': list(cameras),
        'best_single': best,
        'gate_m': each.gate_m,
        'frames': f'{len(instants)} with truth (1 Hz) of {len(each.scene.frame)}',
        'area': 'all that is annotated',
        'settings': _STATED,
    }
    return Figures('lab6p', 'mctrack reproduce lab6p', protocol, figures)


def reproduce_cmc(data: Path) -> Figures:
    """Track 3 and 10 people in a small room with four corner cameras."""
    gates = {'': 1.0, '.gate_half_metre': 0.5}
    figures: dict[str, float] = {}
    for sequence in (1, 2):
        each = cmc(data, sequence)
        tracks = each.tracks()
        for name, gate in gates.items():
            figures |= _figures(f'cmc{sequence}{name}', each.scores(tracks, gate))
        figures |= _disturbed(f'cmc{sequence}.disturbed', each)
    protocol = {
        'detections': 'real Faster R-CNN boxes, on the ground by the whole box',
        'body': str(BodyModel()),
        'gate_m': gates[''],
        'frames': 'all 261 of each sequence that have truth, 4 a second',
        'area': f'x {CMC_AREA[0]}, y {CMC_AREA[1]} m; detections and tracks outside are dropped',
        'disturbed': f'mean and standard deviation of {len(SEEDS)} runs, every detection moved by '
        f'{DISTURBANCE_M:g} m at random along each axis',
        'settings': _STATED,
    }
    return Figures('cmc', 'mctrack reproduce cmc', protocol, figures)


def reproduce_pets_multiview(data: Path) -> Figures:
    """Track PETS 2009 S2.L1 from the stored detections of six views."""
    each = pets_multiview(data)
    tracks = each.tracks()
    passages = by_passage(tracks, AWAY_FRAMES)
    figures = _figures('pets.multiview', each.scores(tracks))
    figures |= _figures('pets.multiview.all_frames', replace(each, first=0).scores(tracks))
    figures |= _figures('pets.multiview.by_passage', each.scores(passages))
    protocol = {
        'detections': f'EPFL Keypoint-RCNN, score > {LEAST_SCORE}, by the whole box',
        'views': list(VIEWS),
        'body': str(BodyModel()),
        'gate_m': each.gate_m,
        'frames': f'{PETS_SPLIT}-795 (all_frames: 1-795)',
        'area': 'rectangle that the truth spans, where view 1 shows it; '
        'truth of confidence 0 is ignored',
        'by_passage': 'the same tracks; one that is not in this area for more than '
        f'{AWAY_FRAMES} frames has a new id when it is back, as the truth of view 1 has it: the '
        'woman in red who leaves as its person 10 comes back as 6; other views see her '
        'meanwhile. Added after looking at the frames that are reported',
        'settings': _STATED,
    }
    return Figures('pets_multiview', 'mctrack reproduce pets', protocol, figures)


def reproduce_wildtrack(data: Path) -> Figures:
    """Track WILDTRACK's training split from OpenPose detections, and from its own boxes."""
    each = wildtrack(data)
    tracks = each.tracks()
    figures = _figures('wildtrack', each.scores(tracks))
    figures |= _figures('wildtrack.gate_half_metre', each.scores(tracks, 0.5))
    for method in ASSOCIATORS:
        scores = each.scores(each.tracks({'association.method': method}))
        figures |= {
            f'wildtrack.{method}.mota': scores.mota,
            f'wildtrack.{method}.idf1': scores.idf1,
            f'wildtrack.{method}.switches': scores.switches,
        }
    boxes = wildtrack_boxes(data)
    tracks = boxes.tracks()
    figures |= _figures('wildtrack.perfect', boxes.scores(tracks))
    later = replace(boxes, first=WILDTRACK_SPLIT).scores(tracks)
    figures |= _figures('wildtrack.perfect.second_half', later)
    protocol = {
        'detections': f'Social-Pose, real OpenPose feet, {_WILDTRACK_KIND}; ankles {ANKLE_M:g} m '
        f'up, as measured on frames 0 to {WILDTRACK_SPLIT - 1}',
        'foot_sigma_px': _WILDTRACK_SIGMA_PX,
        'cameras': list(each.scene.cameras),
        'gate_m': '1 (tracking), 0.5 (detection: gate_half_metre)',
        'frames': 'training split, 360, 2 a second',
        'area': f'x {WILDTRACK_AREA[0]}, y {WILDTRACK_AREA[1]} m; tracks outside are dropped',
        'settings': _STATED,
        'perfect': 'lower edges of the annotated boxes that end in the image, '
        f'{_BOX_SIGMA_PX:g} px (second_half: frames from {WILDTRACK_SPLIT} on)',
    }
    return Figures('wildtrack', 'mctrack reproduce wildtrack', protocol, figures)


def _disturbed(prefix: str, each: StoredSet) -> dict[str, float]:
    """Return the scores, mean and deviation, of a set whose detections are moved a little."""
    runs = [moved.scores(moved.tracks()) for moved in map(each.disturbed, SEEDS)]
    figures = {}
    for name in ('mota', 'idf1', 'switches'):
        values = [getattr(scores, name) for scores in runs]
        figures[f'{prefix}.{name}'] = float(np.mean(values))
        figures[f'{prefix}.{name}_deviation'] = float(np.std(values, ddof=1))
    return figures


def by_passage(tracks: Trajectories, away: int) -> Trajectories:
    """
    Give tracks a new id wherever they are missing for more frames than that.

    Parameters
    ----------
    tracks : Trajectories
        Of an area that they may leave and come back to.
    away : int
        So many frames may be missing.

    Returns
    -------
    Trajectories
        The same rows.

    """
    order = np.lexsort((tracks.frame, tracks.id))
    is_new = np.ones(len(order), np.bool_)
    is_new[1:] = np.diff(tracks.id[order]) != 0
    is_new[1:] |= np.diff(tracks.frame[order]) > away + 1
    passage = np.empty(len(order), np.int64)
    passage[order] = is_new.cumsum()
    return replace(tracks, id=passage)


def _from(first: int, truth: Trajectories, tracks: Trajectories, gate_m: float) -> Scores:
    """Score the frames from one on."""
    later = truth.select(np.asarray(truth.frame >= first))
    return evaluate_ground(later, tracks.select(np.asarray(tracks.frame >= first)), gate_m)


def _figures(prefix: str, scores: Scores) -> dict[str, float]:
    values: dict[str, Any] = {
        'moda': scores.moda,
        'mota': scores.mota,
        'idf1': scores.idf1,
        'hota': scores.hota,
        'switches': scores.switches,
        'false_positives': scores.false_positives,
        'misses': scores.misses,
        'error_m': scores.mean_distance,
    }
    return {f'{prefix}.{name}': value for name, value in values.items()}
