"""A camera whose detections lie off those of the others for a while, compared and not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.bench.fusion.adapter import (
    Reported,
    camera_names,
    messages_of,
    reported,
    told_config,
)
from mctrack_experiments.bench.fusion.toolkit import Scene, Toolkit
from mctrack_experiments.bench.workers import run_spread
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.interfaces import CameraDetections, Tick
from mctrack_ros.replay.drive import drive

Floats = NDArray[np.float64]
Scores = Mapping[str, float]

SECONDS, BEGINS_S, ENDS_S = 80.0, 20.0, 50.0
TICK_S = 0.04
WAYS = ('compared', 'as_they_say')
SPANS = {'wrong': (BEGINS_S, ENDS_S), 'after': (ENDS_S, SECONDS)}
MEASURES = {'mota': 'mota', 'idf1': 'idf1', 'switches': 'switches', 'position_error_m': 'motp'}


@dataclass(frozen=True, slots=True)
class Fault:
    """
    What is wrong with a camera.

    Attributes
    ----------
    shift_m : float
        How far its detections are displaced.
    turn_deg : float
        By how much they are turned about the camera.

    """

    shift_m: float = 0.0
    turn_deg: float = 0.0


FAULTS = {
    'honest': Fault(),
    'displaced_50cm': Fault(0.5),
    'displaced_1m': Fault(1.0),
    'displaced_2m': Fault(2.0),
    'turned_1deg': Fault(turn_deg=1.0),
    'turned_3deg': Fault(turn_deg=3.0),
}


@dataclass(frozen=True, eq=False, slots=True)
class Course:
    """
    What fusion made of a scene.

    Attributes
    ----------
    told : sequence of Reported
        Tracks, one of each tick.
    doubted : (ticks, cameras) bool array
        Whose detections were corrected or weighed down.

    """

    told: Sequence[Reported]
    doubted: NDArray[np.bool_]


def reproduce_biased(
    folder: Path,
    seeds: Sequence[int],
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Figures:
    """
    Let one of five cameras be wrong for half a minute.

    Parameters
    ----------
    folder : Path
        Of the shared fusion benchmark.
    seeds : sequence of int
        One scene for each; which camera, and whither, comes from it too.
    progress : callable
        Told how many scenes are done, of how many.

    """
    jobs = [(folder, name, seed) for name in FAULTS for seed in seeds]
    scores = run_spread(_scored, jobs, progress)
    figures: dict[str, float] = {}
    for name in FAULTS:
        chosen = [score for job, score in zip(jobs, scores) if job[1] == name]
        for key in chosen[0]:
            figures[f'{name}.{key}'] = float(np.mean([score[key] for score in chosen]))
    return Figures('biased', 'mctrack reproduce biased', _protocol(seeds), figures)


def _scored(job: tuple[Path, str, int]) -> Scores:
    folder, name, seed = job
    toolkit = Toolkit(folder)
    scene = toolkit.scene(_ticks(SECONDS), seed)
    camera = seed % scene.scenario.cameras
    courses = {way: run(scene, FAULTS[name], camera, way == 'compared') for way in WAYS}
    figures = dict(times(courses['compared'].doubted, camera, name != 'honest'))
    for way, course in courses.items():
        for span, (start_s, end_s) in SPANS.items():
            score = toolkit.score(
                _until(scene, end_s), course.told[: _ticks(end_s)], skip=_ticks(start_s)
            )
            figures |= {
                f'{span}.{way}.{measure}': float(getattr(score, word))
                for measure, word in MEASURES.items()
            }
    return figures


def run(scene: Scene, fault: Fault, camera: int, compared: bool) -> Course:
    """Track a scene in whose middle a camera is wrong, with cameras compared or not."""
    config = told_config(scene.scenario)
    config = replace(config, motion=replace(config.motion, compare_cameras=compared))
    told, doubted = [], []
    for ticked in drive(config, camera_names(scene.scenario), _seen(scene, fault, camera)):
        told.append(reported(ticked.output.tracks))
        assert ticked.bias is not None
        doubted.append(ticked.bias.offset.any(axis=1) | (ticked.bias.variance > 0))
    return Course(told, np.array(doubted))


def _seen(scene: Scene, fault: Fault, camera: int) -> Iterator[Tick]:
    """Yield a scene's ticks; a camera is wrong in its middle."""
    place = scene.scenario.sensors.camera_position[camera]
    for frame in range(scene.scenario.frames):
        messages = messages_of(scene.scenario, frame)
        if _ticks(BEGINS_S) <= frame < _ticks(ENDS_S):
            messages[camera] = spoiled(messages[camera], fault, place, float(camera))
        yield Tick.of(messages)


def spoiled(
    message: CameraDetections, fault: Fault, camera: Floats, heading: float
) -> CameraDetections:
    """Return what a camera at a place, (2,) m, detects with a fault; displaced by a heading."""
    rows = message.rows
    turn = np.radians(fault.turn_deg)
    cos, sin = np.cos(turn), np.sin(turn)
    position = rows.position.copy()
    position[:, :2] = (position[:, :2] - camera) @ np.array([[cos, sin], [-sin, cos]]) + camera
    position[:, :2] += fault.shift_m * np.array([np.cos(heading), np.sin(heading)])
    return CameraDetections(message.camera, rows.replace(position=position))


def times(doubted: NDArray[np.bool_], camera: int, is_wrong: bool) -> Scores:
    """
    Return how soon who is doubted.

    Parameters
    ----------
    doubted : (ticks, cameras) bool array
        Whose detections were not taken as they are.
    camera : int
        Who was wrong for a while.
    is_wrong : bool
        Whether he was.

    Returns
    -------
    mapping of str to float
        ``blamed``: share of ticks and cameras that are doubted for nothing; a camera after its
        fault is not counted. Of a fault ``found_s``: from its begin to the first doubt;
        ``mended_s``: from its end to the last one, s.

    """
    begins, ends = _ticks(BEGINS_S), _ticks(ENDS_S)
    others = np.delete(doubted, camera, axis=1)
    share = {'blamed': float(np.append(others.ravel(), doubted[:begins, camera]).mean())}
    if not is_wrong:
        return share
    own = doubted[:, camera]
    last = np.flatnonzero(own[ends:])
    found_s = float(own[begins:ends].argmax()) * TICK_S if own[begins:ends].any() else np.nan
    mended_s = float(last[-1] + 1) * TICK_S if len(last) else 0.0
    return share | {'found_s': found_s, 'mended_s': mended_s}


def _until(scene: Scene, end_s: float) -> Scene:
    """Return a scene whose truth ends sooner."""
    truth = scene.scenario.truth[: _ticks(end_s)]
    return replace(scene, scenario=replace(scene.scenario, truth=truth))


def _ticks(seconds: float) -> int:
    return round(seconds / TICK_S)


def _protocol(seeds: Sequence[int]) -> dict[str, str]:
    return {
        'scenes': f'25 targets, 5 cameras of the shared fusion benchmark, {SECONDS:g} s, '
        f'{len(seeds)} seeds, {min(seeds)} to {max(seeds)}; gate 1 m; means',
        'fault': f'of one camera, from {BEGINS_S:g} s to {ENDS_S:g} s: all its detections are '
        'displaced one way, or turned about it',
        'wrong, after': 'scored while it lasts, and from its end on',
        'compared, as_they_say': 'motion.compare_cameras on and off, on the same detections',
        'found_s, mended_s': 'from the begin of the fault until it is doubted, and from its end '
        'until it is believed again',
        'blamed': 'share of ticks and cameras that are doubted and have no fault',
    }
