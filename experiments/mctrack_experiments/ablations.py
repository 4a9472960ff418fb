"""
What each rule of fusion is worth: the same detections fused with it and without.

``python -m mctrack_experiments.ablations DATA --cache DIR --json FILE`` prints a table with a row
for each rule and data set: the score with all rules, and what changes without this one. Both are
means over runs in which every detection is moved a little at random; a change of less than two or
three of its standard errors is luck. ``--closed-loop`` runs the cameras, too, with each rule and
without, where feedback matters; ``--cameras`` does so for the rules of cameras, there also on
disturbed matches (``robustness``) and on changing views (``views``). ``--gap 5`` leaves out 5 s of
every 10 s of the stored detections: what is lost while nobody looks. ``--cells`` is about the
fusion of cells: the cameras of the stored detections in two cells, and simulated sites.
``--masks`` is about the joint occupancy of masks that were recorded once: the terrace, the hall.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import multiprocessing
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from mctrack_experiments.bench.cells.bench import site_figures
from mctrack_experiments.datasets.stored import blinded
from mctrack_experiments.papers.event_tracking.robustness import (
    DISTURBANCES,
    STEPPED,
    reproduce_robustness,
)
from mctrack_experiments.pixel_scenes import (
    FIGURES,
    PITCH_SEEDS,
    PixelScene,
    Scores,
    four_terrace_cameras,
    hall_masks,
    pets,
    pitch,
    terrace_videos,
)
from mctrack_experiments.pixel_scenes import disturbed as disturbed_ticks
from mctrack_experiments.real.stored.cells import track_in_cells
from mctrack_experiments.real.stored.detections import DATA_SETS, DISTURBANCE_M, StoredSet
from mctrack_experiments.scenarios.changing_views import SCENES, score, tracked
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion.association import likelihood
from mctrack_ros.fusion.cells import links
from mctrack_ros.fusion.cells import pipeline as cell_pipeline
from mctrack_ros.fusion.existence import evidence
from mctrack_ros.fusion.existence.view_overlap import ViewOverlap
from mctrack_ros.fusion.joint_tracker import pipeline as joint_pipeline
from mctrack_ros.fusion.management import initiation, lifecycle
from mctrack_ros.fusion.occupancy import masks, scene
from mctrack_ros.fusion.occupancy import pipeline as occupancy
from mctrack_ros.fusion.reid import lost_targets, reassignment
from mctrack_ros.fusion.update import hidden_members, update
from mctrack_ros.interfaces import Tick
from mctrack_ros.perception.background import model
from mctrack_ros.perception.background.light import Light
from mctrack_ros.perception.background.noise import NoiseMap
from mctrack_ros.perception.background.shadows import Shadows
from mctrack_ros.perception.blobs import extraction
from mctrack_ros.perception.event_tracker import tracker
from mctrack_ros.perception.events import view_events
from mctrack_ros.perception.local_tracks.table import LocalTracks
from mctrack_ros.replay import camera_source, workers

SEEDS = range(1, 4)
ROBUSTNESS_SEEDS, ROBUSTNESS_S = (1,), 16.0
FIRST_GAP_S, LATER_GAP_S = 3.0, 1.7
"""When nobody looks for the first time, and how much later in each further run, s."""
CELL_SEEDS = range(1, 4)
"""Of simulated sites of cells; `bench cells` has others."""
CLOSED_PITCH = 2
"""So many matches are tracked in a closed loop."""


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
        What is replaced, by module and name.
    feeds_back : bool
        Whether what cameras are told, or tell, matters.

    """

    what: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    patches: Mapping[tuple[Any, str], Any] = field(default_factory=dict)
    feeds_back: bool = False


RULES = {
    'appearance': Rule('colours in the cost of a pair', {'association.appearance_weight': 0.0}),
    'usual difference': Rule(
        'colours as alike as those of one person usually are speak for a pair',
        {'association.usual_difference': 0.0},
    ),
    'tentative cost': Rule(
        'a track that is not confirmed gives way', patches={(likelihood, 'TENTATIVE_COST'): 0.0}
    ),
    'camera comparison': Rule(
        'cameras that lie off the others are corrected', {'motion.compare_cameras': False}
    ),
    'crowd evidence': Rule(
        'what begins beside others has to be seen for longer',
        patches={(initiation, 'CROWD_EVIDENCE'): 0.0},
    ),
    'miss weight': Rule(
        'a miss counts less for the confirmed', patches={(evidence, 'MISS_WEIGHT'): 1.0}
    ),
    'gone': Rule(
        'who has most probably gone is not published',
        patches={(lifecycle, 'GONE_EVIDENCE'): 1000.0},
    ),
    'hidden time': Rule(
        'a group keeps a member only for a while', patches={(hidden_members, 'HIDDEN_S'): 1000.0}
    ),
    'hidden members': Rule(
        'a group keeps its members', patches={(update, 'keep_members'): lambda *_: None}
    ),
    'view overlap': Rule(
        'cameras that see nobody together count less',
        patches={(ViewOverlap, 'share'): lambda self: np.ones_like(self.together)},
    ),
    'merge': Rule('two tracks of one target become one', {'management.merge_distance': 0.0}),
    're-entry': Rule(
        'the lost are found by prediction and colours',
        patches={(lost_targets, 'ARRIVAL_DENSITY'): 100.0},
    ),
    'contacts': Rule('ids are corrected after encounters', {'reid.contact_distance': 0.0}),
    'strange': Rule(
        'who looks like nobody decides nothing',
        patches={(reassignment, 'OUTLIER_DISTANCE'): 1000.0},
    ),
    'keep': Rule('an id is kept in doubt', patches={(reassignment, 'KEEP'): 0.0}),
    'blind time': Rule(
        'tracks outlast a time without ticks', patches={(joint_pipeline, 'BLIND_S'): math.inf}
    ),
}

CAMERA_RULES = {
    'shadows': Rule(
        'shadows by the sun are no foreground', patches={(Shadows, 'take_out'): lambda *_: None}
    ),
    'shadows alone': Rule(
        'blobs of nothing but shade are nobody',
        patches={(Shadows, 'alone'): lambda *given: np.zeros(len(given[4]), np.bool_)},
    ),
    'noise map': Rule(
        'parts of the image are noisier than others',
        patches={(NoiseMap, 'learn'): lambda *_: None},
    ),
    'light': Rule(
        'the background follows the light',
        patches={(Light, 'follow'): lambda *_, **__: np.ones(3)},
    ),
    'view change': Rule(
        'a background that is lit anew or shifted is taken over',
        patches={(model, 'scene_after'): lambda *_: None},
    ),
    'walked': Rule(
        'who walked in and stands becomes no background',
        patches={(tracker.LocalTracker, 'walked_ids'): lambda _: np.zeros(0, np.int64)},
    ),
    'first pass': Rule(
        'the background of a recording is learned beforehand',
        patches={(camera_source, 'plate_of'): lambda task: None},
    ),
    'fragments': Rule(
        'pieces the size of one person are joined',
        patches={(extraction, 'joined'): lambda box, *_: box},
    ),
    'touching': Rule(
        'who touches another is a group with him',
        patches={(view_events, 'contacts'): lambda box, *_: np.arange(len(box))},
    ),
    'group detections': Rule(
        'of a group with hidden members there is one detection',
        patches={
            (tracker, 'merged_detections'): lambda view, part, shown: shown.select(np.arange(0))
        },
    ),
    'begun by feedback': Rule(
        'members of groups whom fusion alone knows have tracks',
        patches={(tracker, 'begin_hidden'): lambda *_: None},
    ),
    'foot noise': Rule(
        'errors of feet are learned', patches={(LocalTracks, 'follow_noise'): lambda *_: None}
    ),
}

CELL_RULES = {
    'hold': Rule("a link of a cell's track is kept in doubt", patches={(links, 'HOLD'): 0.0}),
    'memory': Rule('the evidence of a link is averaged', patches={(links, 'MEMORY_S'): 1e-6}),
    'decide': Rule(
        'who comes up beside known targets waits until it is decided who it is',
        patches={(links, 'DECIDE_S'): 0.0},
    ),
    'limit': Rule('one bad state decides nothing', patches={(links, 'LIMIT'): 400.0}),
    'suspects': Rule(
        'a cell whose track has jumped is the first to be wrong',
        patches={(links, 'DOUBTED_S'): 0.0},
    ),
    'joining': Rule(
        'two targets of one person become one', patches={(cell_pipeline, 'JOIN_M'): 0.0}
    ),
}

MASK_RULES = {
    'prior': Rule(
        'a predicted track adds to the gain of its place', patches={(masks, 'PRIOR_GAIN'): 0.0}
    ),
    'colours of cameras': Rule(
        "people have the colours of the cameras' detections", patches={(occupancy, 'NEAR_M'): 0.0}
    ),
    'last mask': Rule(
        "a slower camera's last mask counts", patches={(masks, 'OLDEST_NS'): 100_000_000}
    ),
    'left out': Rule(
        'dazzled and frozen cameras do not count',
        patches={(masks, 'MOST_FOREGROUND'): 2.0, (masks, 'FROZEN_NS'): 10**18},
    ),
    'apart': Rule('two people do not share a place', patches={(scene, 'LEAST_DISTANCE_M'): 0.0}),
    'moves': Rule('people are moved while they are chosen', patches={(scene, 'REACH_M'): 0.0}),
    'margin': Rule(
        'people beside the stated area are looked for, too', patches={(scene, 'MARGIN_M'): 0.0}
    ),
    'least seen': Rule(
        'who is mostly outside an image is not looked for there',
        patches={(scene, 'LEAST_SEEN'): 0.01},
    ),
    'least height': Rule(
        'who would look too small is not looked for', patches={(scene, 'LEAST_HEIGHT_PX'): 1.0}
    ),
    'least resolution': Rule(
        'nobody is looked for where a metre moves him by a few pixels',
        patches={(scene, 'LEAST_PX_PER_M'): 0.0},
    ),
}


@dataclass(frozen=True)
class DataSet:
    """
    Detections with truth.

    Attributes
    ----------
    runs : sequence of int
        Seeds of the disturbance, or of the matches.
    scores : callable
        Fuses them with some settings and for one of the runs.
    figures : sequence of str
        What is scored.

    """

    runs: Sequence[int]
    scores: Callable[[Mapping[str, Any], int], Scores]
    figures: Sequence[str] = FIGURES


def stored_sets(data: Path, gap_s: float = 0.0) -> dict[str, DataSet]:
    """Return the real data sets whose detections others made, by name, with gaps of so many s."""

    def stored(each: StoredSet) -> DataSet:
        def scores(extra: Mapping[str, Any], seed: int) -> Scores:
            moved = replace(each.disturbed(seed), first=0)
            begin_s = FIRST_GAP_S + LATER_GAP_S * seed
            moved = replace(moved, scene=blinded(moved.scene, gap_s, begin_s))
            scored = moved.scores(moved.tracks(extra))
            return {name: float(getattr(scored, name)) for name in FIGURES}

        return DataSet(SEEDS, scores)

    return {name: stored(open_set(data)) for name, open_set in DATA_SETS.items()}


def pixel_sets(data: Path, folder: Path) -> dict[str, DataSet]:
    """Return the data sets whose detections come from pixels, with a folder for these, by name."""

    @cache
    def match(seed: int) -> tuple[PixelScene, list[Tick]]:
        scene = pitch(seed, folder)
        return scene, scene.ticks(folder)

    def play(extra: Mapping[str, Any], seed: int) -> Scores:
        scene, ticks = match(seed)
        return scene.fused(disturbed_ticks(ticks, DISTURBANCE_M, seed), extra)

    def filmed(scene: PixelScene) -> DataSet:
        @cache
        def ticks() -> list[Tick]:
            return scene.ticks(folder)

        return DataSet(
            SEEDS,
            lambda extra, seed: scene.fused(disturbed_ticks(ticks(), DISTURBANCE_M, seed), extra),
        )

    return {
        'pitch': DataSet(PITCH_SEEDS, play),
        'pets, pixels': filmed(pets(data)),
        'terrace, two cameras': filmed(terrace_videos(data, folder)),
        'terrace, four cameras': filmed(four_terrace_cameras(data, folder)),
    }


def closed_loops(data: Path, folder: Path) -> dict[str, DataSet]:
    """Return those where cameras are run again, with a folder for what they make, by name."""

    def terrace(tracker: str, extra: Mapping[str, Any], seed: int) -> Scores:
        scene = four_terrace_cameras(data, folder, seed, tracker)
        return scene.closed_loop(extra, folder / 'closed')

    def film(extra: Mapping[str, Any], _: int) -> Scores:
        return terrace_videos(data, folder).closed_loop(extra, folder / 'closed')

    def watch(extra: Mapping[str, Any], seed: int) -> Scores:
        return pets(data).closed_loop(extra, folder / 'closed')

    def play(extra: Mapping[str, Any], seed: int) -> Scores:
        return pitch(seed, folder).closed_loop(extra, folder / 'closed')

    return {
        'pitch, closed loop': DataSet(PITCH_SEEDS[:CLOSED_PITCH], play),
        'terrace, four cameras, closed loop': DataSet(range(3), partial(terrace, '')),
        'terrace, four cameras, joint, closed loop': DataSet(range(3), partial(terrace, 'joint')),
        'terrace, two cameras, closed loop': DataSet((0,), film),
        'pets, closed loop': DataSet((1,), watch),
    }


def changing_scenes() -> dict[str, DataSet]:
    """Return the scenes that try the rules of cameras: disturbed matches, changing views."""

    def robustness(_: Mapping[str, Any], seed: int) -> Scores:
        values = reproduce_robustness([seed], ROBUSTNESS_S).figures
        recovery = [min(values[f'{name}.recovery_max_s'], ROBUSTNESS_S) for name in STEPPED]
        return {
            'mota': float(np.mean([values[f'{name}.mota'] for name in DISTURBANCES])),
            'false': float(np.mean([values[f'{name}.false'] for name in DISTURBANCES])),
            'recovery_s': float(np.mean(recovery)),
        }

    def views(_: Mapping[str, Any], seed: int) -> Scores:
        scored = [score(scene(), tracked(scene(), seed)) for scene in SCENES.values()]
        return {
            'false_s': sum(each['false_s'] for each in scored),
            'most_false': max(each['most_false'] for each in scored),
            'longest_miss_s': max(each['longest_miss_s'] for each in scored),
        }

    return {
        'robustness': DataSet(ROBUSTNESS_SEEDS, robustness, ('mota', 'false', 'recovery_s')),
        'views': DataSet(SEEDS, views, ('false_s', 'most_false', 'longest_miss_s')),
    }


def cell_sets(data: Path) -> dict[str, DataSet]:
    """Return sites of cells: the real data sets with their cameras in two, and simulated ones."""

    def stored(each: StoredSet) -> DataSet:
        def scores(_: Mapping[str, Any], seed: int) -> Scores:
            moved = replace(each.disturbed(seed), first=0)
            tracks = track_in_cells(moved.scene).at_frames(moved.scene.truth.frame)
            scored = moved.scores(tracks.select(moved.counts(tracks.position)))
            return {name: float(getattr(scored, name)) for name in FIGURES}

        return DataSet(SEEDS, scores)

    def simulated(_: Mapping[str, Any], seed: int) -> Scores:
        values = site_figures(seed)
        return {name: values[f'cells.{name}'] for name in FIGURES}

    found = {f'{name}, two cells': stored(open_set(data)) for name, open_set in DATA_SETS.items()}
    return found | {'sites of 4 to 8 cells': DataSet(CELL_SEEDS, simulated)}


@contextlib.contextmanager
def left_out(rule: Rule) -> Iterator[Mapping[str, Any]]:
    """Leave a rule out, in processes that are forked, too; yield the settings that do so."""
    patches = {**rule.patches, (workers, 'worker_context'): _fork}
    kept = {key: getattr(*key) for key in patches}
    for (owner, name), value in patches.items():
        setattr(owner, name, value)
    try:
        yield rule.settings
    finally:
        for (owner, name), value in kept.items():
            setattr(owner, name, value)


def ablate(
    data_sets: Mapping[str, DataSet],
    rules: Mapping[str, Rule],
    progress: Callable[[str], None] = lambda line: None,
) -> tuple[Figures, list[str]]:
    """
    Fuse every data set with each rule and without.

    Parameters
    ----------
    data_sets : mapping of str to DataSet
        By name.
    rules : mapping of str to Rule
        By name.
    progress : callable
        Told what is being done.

    Returns
    -------
    Figures
        Mean scores, losses and their standard errors over the runs, paired.
    list of str
        The rows of the table, as Markdown.

    """
    figures: dict[str, float] = {}
    rows: list[str] = []
    named: Sequence[str] = ()
    for place, data_set in data_sets.items():
        if data_set.figures != named:
            named = data_set.figures
            rows += [
                '',
                f'| rule | data | {" | ".join(named)} |',
                f'|---|---|{"---|" * len(named)}',
            ]
        whole = [data_set.scores({}, run) for run in data_set.runs]
        figures |= {f'{place}.{name}': _mean(whole, name) for name in named}
        for name, rule in rules.items():
            with left_out(rule) as settings:
                without = [data_set.scores(settings, run) for run in data_set.runs]
            cells = []
            for figure in named:
                change = [b[figure] - a[figure] for a, b in zip(whole, without)]
                mean, error = float(np.mean(change)), _error(change)
                figures[f'{place}.{name}.{figure}'] = mean
                figures[f'{place}.{name}.{figure}_error'] = error
                cells.append(f'{_mean(whole, figure):.3f} {mean:+.4f} ± {error:.4f}')
            rows.append(f'| {name} | {place} | {" | ".join(cells)} |')
            progress(rows[-1])
    protocol = {
        'change': 'without the rule, paired by run, mean and standard error',
        'runs': f'{len(SEEDS)}, on the pitch {len(PITCH_SEEDS)} matches; every detection is moved '
        f'by {DISTURBANCE_M:g} m along each axis',
        'rules': {name: rule.what for name, rule in rules.items()},
    }
    command = 'python -m mctrack_experiments.ablations'
    return Figures('ablations', command, protocol, figures), rows


def mask_sets(data: Path, folder: Path) -> dict[str, DataSet]:
    """Return masks that are fused again, with a folder where they are recorded."""

    def terrace(extra: Mapping[str, Any], run: int) -> Scores:
        scene = four_terrace_cameras(data, folder / 'masks', run, 'occupancy')
        return scene.fused_again(extra, folder / 'masks')

    def hall(extra: Mapping[str, Any], seed: int) -> Scores:
        return hall_masks(seed, folder).fused_again(extra, folder)

    return {
        'terrace, masks': DataSet(range(3), terrace),
        'hall, masks': DataSet(SEEDS, hall),
    }


def _fork() -> Any:
    cv2.setNumThreads(1)  # a process that is forked beside threads of OpenCV waits for ever
    return multiprocessing.get_context('fork')


def _mean(scores: list[Scores], name: str) -> float:
    return float(np.mean([each[name] for each in scores]))


def _error(values: list[float]) -> float:
    if len(values) < 2:
        return math.nan
    return float(np.std(values, ddof=1) / math.sqrt(len(values)))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog='ablations', description=__doc__)
    parser.add_argument('data', type=Path, help='folder of the real data')
    parser.add_argument('--cache', type=Path, help='folder for what cameras make of pixels')
    parser.add_argument('--closed-loop', action='store_true', help='run the cameras each time')
    parser.add_argument('--cameras', action='store_true', help='the rules of cameras')
    parser.add_argument('--cells', action='store_true', help='the rules of the fusion of cells')
    parser.add_argument('--masks', action='store_true', help='the rules of joint occupancy')
    parser.add_argument('--only', nargs='*', help='rules, by name')
    parser.add_argument('--on', nargs='*', help='data sets, by name')
    parser.add_argument('--gap', type=float, default=0.0, help='nobody looks for so long, s')
    parser.add_argument('--json', type=Path, help='also write the figures here')
    arguments = parser.parse_args()
    of_kind = {'cameras': CAMERA_RULES, 'cells': CELL_RULES, 'masks': MASK_RULES}
    asked = [rules for kind, rules in of_kind.items() if getattr(arguments, kind)]
    all_rules = asked[0] if asked else RULES
    rules = {
        name: rule for name, rule in all_rules.items() if name in (arguments.only or all_rules)
    }
    if arguments.cameras:
        data_sets = closed_loops(arguments.data, arguments.cache) | changing_scenes()
    elif arguments.cells:
        data_sets = cell_sets(arguments.data)
    elif arguments.masks:
        data_sets = mask_sets(arguments.data, arguments.cache)
    elif arguments.closed_loop:
        rules = {name: rule for name, rule in rules.items() if rule.feeds_back or arguments.only}
        data_sets = closed_loops(arguments.data, arguments.cache)
    else:
        data_sets = stored_sets(arguments.data, arguments.gap)
        if arguments.cache:
            data_sets |= pixel_sets(arguments.data, arguments.cache)
    data_sets = {
        name: each for name, each in data_sets.items() if name in (arguments.on or data_sets)
    }
    figures, rows = ablate(data_sets, rules, lambda line: print(line, file=sys.stderr, flush=True))
    print('\n'.join(rows))
    if arguments.json:
        figures.write(arguments.json)


if __name__ == '__main__':
    main()
