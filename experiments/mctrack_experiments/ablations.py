"""
What each rule of fusion is worth: stored detections fused with it and without.

``python -m mctrack_experiments.ablations DATA --json FILE`` prints a table with a row for each
rule and data set: the score with all rules, and what changes without this one. Both are means over
runs in which every detection is moved a little at random; a change of less than two or three of
its standard errors is luck.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_experiments.datasets.cmc import AREA as CMC_AREA
from mctrack_experiments.datasets.cmc import load_cmc
from mctrack_experiments.datasets.lab6p import load_lab6p
from mctrack_experiments.datasets.pets_multiview import annotated, load_pets_multiview
from mctrack_experiments.datasets.stored import StoredScene, disturbed, inside
from mctrack_experiments.datasets.wildtrack import AREA as WILDTRACK_AREA
from mctrack_experiments.datasets.wildtrack import load_wildtrack, load_wildtrack_boxes
from mctrack_experiments.real.stored_detections import (
    CMC_SETTINGS,
    LAB6P_SETTINGS,
    PERFECT_SETTINGS,
    PETS_SETTINGS,
    WILDTRACK_SETTINGS,
    Settings,
)
from mctrack_experiments.real.stored_tracking import track_stored
from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion.management import manager
from mctrack_ros.perception.boxes import BodyModel

SEEDS, MOVED_M = range(1, 6), 0.02
FIGURES = ('mota', 'idf1', 'switches')


@dataclass(frozen=True)
class Rule:
    """
    One rule of fusion, and how it is left out.

    Attributes
    ----------
    what : str
        What it does, in a few words.
    settings : mapping
        What is set, by dotted name, to leave it out.
    patches : mapping
        What is replaced in the module of the track manager, by name.

    """

    what: str
    settings: Mapping[str, Any]
    patches: Mapping[str, Any]


RULES = {
    'parting': Rule(
        'who parts from a pair that seem one goes on as the new track',
        {},
        {'parted': lambda *_: []},
    ),
    'twins': Rule('two known tracks in one place are joined', {'life.twin_time': 100.0}, {}),
    'identity bonus': Rule(
        'a camera that believes it is the same target', {'association.identity_bonus': 0.0}, {}
    ),
    'appearance': Rule(
        'colours in the cost of a pair', {'association.appearance_weight': 0.0}, {}
    ),
    'lineage': Rule(
        'a new track shares the past of the group beside it', {'life.crowd_distance': 0.0}, {}
    ),
    'camera comparison': Rule(
        'cameras that lie off the others are corrected', {'motion.compare_cameras': False}, {}
    ),
    'crowd evidence': Rule(
        'what begins beside others has to be seen for longer', {'life.crowd_evidence': 0.0}, {}
    ),
    'vacancies': Rule('bare ground speaks against a track', {'life.vacancy_weight': 0.0}, {}),
}


@dataclass(frozen=True)
class DataSet:
    """Stored detections with truth, and how tracks of them are scored."""

    scene: StoredScene
    settings: Settings
    wanted: Callable[[Trajectories], Trajectories]
    gate_m: float

    def scores(self, extra: Mapping[str, Any], seed: int) -> dict[str, float]:
        """Return the scores with some settings, every detection moved by chance."""
        scene = disturbed(self.scene, MOVED_M, seed)
        tracks = self.wanted(track_stored(scene, {**self.settings, **extra}))
        scores = evaluate_ground(self.scene.truth, tracks, self.gate_m)
        return {name: float(getattr(scores, name)) for name in FIGURES}


def data_sets(data: Path) -> dict[str, DataSet]:
    """Return the real data sets whose detections are stored, by name."""
    pets = data / 'pets2009_s2l1'

    def within(scene: StoredScene, area: Any) -> Callable[[Trajectories], Trajectories]:
        def wanted(tracks: Trajectories) -> Trajectories:
            tracks = tracks.at_frames(scene.truth.frame)
            return tracks if area is None else tracks.select(inside(tracks.position, area))

        return wanted

    lab6p = load_lab6p(data / 'epfl_lab6p', 'proposed_confirmed', 2.0)
    cmc2 = load_cmc(data / 'cmc_4cam', 2, BodyModel())
    views = load_pets_multiview(pets, BodyModel())
    feet = load_wildtrack(data / 'wildtrack', 'proposed_confirmed', 10.0)
    boxes = load_wildtrack_boxes(data / 'wildtrack', 2.0)
    return {
        'lab6p': DataSet(lab6p, LAB6P_SETTINGS, within(lab6p, None), 0.5),
        'cmc2': DataSet(cmc2, CMC_SETTINGS, within(cmc2, CMC_AREA), 1.0),
        'pets, six views': DataSet(
            views,
            PETS_SETTINGS,
            lambda tracks: tracks.select(annotated(pets, tracks.position, views.truth)),
            1.0,
        ),
        'wildtrack': DataSet(feet, WILDTRACK_SETTINGS, within(feet, WILDTRACK_AREA), 1.0),
        'wildtrack boxes': DataSet(boxes, PERFECT_SETTINGS, within(boxes, WILDTRACK_AREA), 1.0),
    }


@contextlib.contextmanager
def left_out(rule: Rule) -> Iterator[Mapping[str, Any]]:
    """Leave a rule out; yield the settings that do so."""
    kept = {name: getattr(manager, name) for name in rule.patches}
    for name, value in rule.patches.items():
        setattr(manager, name, value)
    try:
        yield rule.settings
    finally:
        for name, value in kept.items():
            setattr(manager, name, value)


def ablate(
    data: Path, progress: Callable[[str], None] = lambda line: None
) -> tuple[Figures, list[str]]:
    """
    Fuse every data set with each rule and without.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    progress : callable
        Told what is being done.

    Returns
    -------
    Figures
        Mean scores, losses and their standard errors over the seeds, paired.
    list of str
        The rows of the table, as Markdown.

    """
    figures: dict[str, float] = {}
    rows = ['| rule | data | MOTA | IDF1 | switches |', '|---|---|---|---|---|']
    for place, data_set in data_sets(data).items():
        progress(place)
        whole = [data_set.scores({}, seed) for seed in SEEDS]
        figures |= {f'{place}.{name}': _mean(whole, name) for name in FIGURES}
        for name, rule in RULES.items():
            progress(f'{place}: without {name}')
            with left_out(rule) as settings:
                without = [data_set.scores(settings, seed) for seed in SEEDS]
            cells = []
            for figure in FIGURES:
                change = [b[figure] - a[figure] for a, b in zip(whole, without)]
                mean, error = float(np.mean(change)), _error(change)
                figures[f'{place}.{name}.{figure}'] = mean
                figures[f'{place}.{name}.{figure}_error'] = error
                cells.append(f'{_mean(whole, figure):.3f} {mean:+.4f} ± {error:.4f}')
            rows.append(f'| {name} | {place} | {" | ".join(cells)} |')
    protocol = {
        'change': 'without the rule, paired by seed, mean and standard error',
        'seeds': f'{len(SEEDS)}; every detection is moved by {MOVED_M:g} m along each axis',
        'rules': {name: rule.what for name, rule in RULES.items()},
    }
    command = 'python -m mctrack_experiments.ablations'
    return Figures('ablations', command, protocol, figures), rows


def _mean(scores: list[dict[str, float]], name: str) -> float:
    return float(np.mean([each[name] for each in scores]))


def _error(values: list[float]) -> float:
    return float(np.std(values, ddof=1) / math.sqrt(len(values)))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog='ablations', description=__doc__)
    parser.add_argument('data', type=Path, help='folder of the real data')
    parser.add_argument('--json', type=Path, help='also write the figures here')
    arguments = parser.parse_args()
    figures, rows = ablate(arguments.data, lambda line: print(line, file=sys.stderr, flush=True))
    print('\n'.join(rows))
    if arguments.json:
        figures.write(arguments.json)


if __name__ == '__main__':
    main()
