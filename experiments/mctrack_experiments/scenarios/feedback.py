"""What feedback is worth on the pitch: the same matches with it and without."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_experiments.scenarios.staged.haunted import WINDOW_S, haunted
from mctrack_experiments.scenarios.staged.rates import rate_figures
from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.evaluation.instants import TRUTH_TOPIC, read_instants
from mctrack_ros.interfaces import Tracks
from mctrack_ros.replay.lockstep import camera_tasks, run_lockstep
from mctrack_ros.replay.workers import CameraWorkers
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import Scenario
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.site import load_site

DURATION_S = 40.0
GATE_M = 1.0
MEASURES = ('mota', 'idf1', 'hota', 'recall', 'precision', 'switches', 'fragmentations')
ON, OFF = 'on', 'off'

Progress = Callable[[str], None]


def reproduce_feedback(
    seeds: Sequence[int],
    duration_s: float = DURATION_S,
    progress: Progress = lambda line: None,
) -> Figures:
    """
    Track matches with feedback, without, and with feedback that tells of ghosts.

    Parameters
    ----------
    seeds : sequence of int
        Matches; each is tracked three times.
    duration_s : float
        Length of each, s.
    progress : callable
        Told what is being done.

    """
    scores: dict[str, list[dict[str, float]]] = {ON: [], OFF: []}
    dies: list[bool] = []
    for seed in seeds:
        progress(f'seed {seed}')
        with tempfile.TemporaryDirectory() as scratch:
            match = Path(scratch) / 'match'
            simulate(Scenario(seed=seed, duration_s=duration_s), match)
            for name, score in both(match).items():
                scores[name].append(score)
            dies += haunted(match, seed, int(duration_s // WINDOW_S))
    figures = {
        f'{name}.{measure}': float(np.mean([score[measure] for score in scores[name]]))
        for name in scores
        for measure in MEASURES
    }
    figures |= {
        f'gain.{measure}': figures[f'{ON}.{measure}'] - figures[f'{OFF}.{measure}']
        for measure in MEASURES
    }
    figures |= rate_figures('ghost.dies', dies)
    return Figures(
        'feedback',
        'mctrack reproduce feedback',
        {
            'scene': f'pitch5, {duration_s:g} s, 5 cameras, 25 people, backgrounds learned',
            'seeds': f'{", ".join(map(str, seeds))}; developed on 1 to 6, 61 and 62; '
            'means of the matches',
            'gate_m': GATE_M,
            'off': 'no camera is ever told anything; fusion is the same',
            'gain': 'with feedback less without',
            'ghost': 'targets that are not there, of which every camera is told for 2 s; dies: '
            'nothing is reported there a second later',
        },
        figures,
    )


def both(match: Path) -> dict[str, dict[str, float]]:
    """Track a match with feedback and without; return the scores."""
    truth = read_instants(match, (TRUTH_TOPIC,))
    scores = {}
    for name, kind in {ON: CameraWorkers, OFF: Unheard}.items():
        true, tracks = (
            Trajectories.from_tracks(each, truth.period_ns)
            for each in (truth.instants, track(match, kind))
        )
        scores[name] = evaluate_ground(true, tracks, GATE_M).figures()
    return scores


class Unheard(CameraWorkers):
    """Cameras that no feedback reaches."""

    def announce(self, tick_index: int, feedback: Sequence[Any]) -> None:
        """Tell them only how far fusion is."""
        super().announce(tick_index, ())


def track(match: Path, kind: type[CameraWorkers]) -> Iterator[Tracks]:
    """Yield the tracks of every tick of a match, with cameras of some kind."""
    site = load_site(config_file('pitch5.yaml'))
    tasks = camera_tasks(match, site)
    with closing(kind(tasks, len(tasks))) as workers:
        yield from (ticked.output.tracks for _, ticked in run_lockstep(workers, site))
