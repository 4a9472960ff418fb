"""Who keeps whom when people pass each other on EPFL's terrace, before two cameras."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from mctrack_experiments.bench.workers import run_spread
from mctrack_experiments.datasets.epfl_terrace import (
    metres_from_top_view,
    read_identities,
    read_positions,
)
from mctrack_experiments.real.terrace import videos as terrace
from mctrack_experiments.real.terrace.four_cameras import (
    FIRST_OF_VIDEO,
    TUNED_TO,
    read_tracks,
    scored,
)
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.recording.video.videos import open_video
from mctrack_ros.replay.track import track_bag
from mctrack_ros.site.site import SiteConfig, load_site

Floats = NDArray[np.float64]

NEAR_M = 1.0
"""Two people pass each other while they are so near on the ground."""
AFTER_FRAMES = 25
"""So long before and after, they are asked for: 1 s."""
GATE_M = 1.0
"""A track is somebody's who is so near."""
TRACKERS = ('belief', 'default')


def crossing_figures(data: Path) -> dict[str, float]:
    """Return how many crossings the first half has, and what share of them each tracker keeps."""
    frames = range(FIRST_OF_VIDEO, TUNED_TO + 1)
    truth = read_identities(data, terrace.CAMERAS).at_frames(frames)
    passes = crossings(truth)
    figures: dict[str, float] = {'crossings': float(len(passes))}
    for name, tracks in zip(TRACKERS, run_spread(_tracked, [(data, name) for name in TRACKERS])):
        figures[f'{name}.crossings.kept'] = float(
            np.mean([is_kept(each, truth, tracks) for each in passes])
        )
        scores = scored(tracks, read_positions(data), truth, frames)
        figures |= {f'{name}.terrace.{key}': scores[key] for key in ('mota', 'idf1')}
    return figures


Crossing = tuple[int, int, int, int]
"""Two persons, the frame before they are near, and the one after."""


def crossings(truth: Trajectories) -> list[Crossing]:
    """
    Return when two people passed each other.

    That is a time in which they come within `NEAR_M` again and again, at most twice
    `AFTER_FRAMES` apart; `AFTER_FRAMES` before and after, both are annotated.
    """
    found = []
    people = np.unique(truth.id).tolist()
    paths = {
        one: dict(zip(truth.frame[truth.id == one].tolist(), truth.position[truth.id == one]))
        for one in people
    }
    for index, one in enumerate(people):
        for other in people[index + 1 :]:
            found += [
                (one, other, first, last) for first, last in _passes(paths[one], paths[other])
            ]
    return found


def _passes(one: dict[int, Floats], other: dict[int, Floats]) -> Iterator[tuple[int, int]]:
    """Yield the frames before and after two paths are near."""
    both = np.array(sorted(one.keys() & other.keys()))
    gap = np.array([np.hypot(*(one[frame] - other[frame])) for frame in both])
    near = both[gap < NEAR_M]
    for run in np.split(near, np.flatnonzero(np.diff(near) > 2 * AFTER_FRAMES) + 1):
        if len(run) and {run[0] - AFTER_FRAMES, run[-1] + AFTER_FRAMES} <= set(both.tolist()):
            yield int(run[0]) - AFTER_FRAMES, int(run[-1]) + AFTER_FRAMES


def is_kept(crossing: Crossing, truth: Trajectories, tracks: Trajectories) -> bool:
    """Tell whether both have a track before, of their own, and the same after."""
    *people, begin, end = crossing
    before, after = (_owners(frame, people, truth, tracks) for frame in (begin, end))
    return None not in before and before == after and before[0] != before[1]


def _owners(
    frame: int, people: list[int], truth: Trajectories, tracks: Trajectories
) -> list[int | None]:
    """Return the track that is nearest to each of some people, within the gate."""
    there = tracks.at_frames([frame])
    owners: list[int | None] = []
    for person in people:
        place = truth.position[(truth.frame == frame) & (truth.id == person)][0]
        gap = np.hypot(*(there.position - place).T)
        is_there = len(gap) > 0 and bool(gap.min() <= GATE_M)
        owners.append(int(there.id[gap.argmin()]) if is_there else None)
    return owners


def _tracked(job: tuple[Path, str]) -> Trajectories:
    """Track both videos of a folder by a tracker."""
    data, name = job
    with tempfile.TemporaryDirectory(prefix='mctrack_belief_') as folder_name:
        folder = Path(folder_name)
        videos = {camera: open_video(terrace.video(data, camera)) for camera in terrace.CAMERAS}
        track_bag(videos, folder / 'out', _site(data, folder, name))
        tracks = read_tracks(folder / 'out', 1)
    top_view_px = tracks.position / terrace.METRES_PER_TOP_VIEW_PX
    return replace(tracks, position=metres_from_top_view(top_view_px))


def _site(data: Path, folder: Path, name: str) -> SiteConfig:
    site = terrace.write_site(data, folder)
    if name != 'belief':
        return site
    path = folder / 'site.yaml'
    settings = yaml.safe_load(path.read_text())
    settings |= {'pipeline': {'local_tracker': name}, 'fusion': {'tracker': name}}
    path.write_text(yaml.safe_dump(settings))
    return load_site(path)
