"""
One camera by itself, from pixels: who is found in the single view, and followed.

``python -m mctrack_experiments.real.single_view DATA --cache DIR`` prints a row for each part of
each scene. Truth is what that camera shows. Detections without feedback count, by their local
tracks; with ``--fused`` the tracks of fusion.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from mctrack_experiments.datasets import epfl_terrace as terrace
from mctrack_experiments.datasets.stored import inside
from mctrack_experiments.papers.event_tracking.tracked_match import with_backgrounds
from mctrack_experiments.real import pets_pixels
from mctrack_experiments.real.terrace import videos as terrace_videos
from mctrack_ros.codec import image_from_message
from mctrack_ros.config import config_from
from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.fusion import JointConfig
from mctrack_ros.ground import GroundMapping, read_calibration
from mctrack_ros.interfaces import CameraDetections, Detections, Feedback, Tick
from mctrack_ros.perception import EventTracker, EventTrackerConfig, FeedbackBuffer
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.video.videos import open_video
from mctrack_ros.replay.drive import drive
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import Scenario, World
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.site import load_site

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]
GATE_M = 1.0
SPREAD_IMAGES = 50
"""So many images, spread over a clip that never shows an empty scene, give its background."""
PITCH_S = 30.0


@dataclass(frozen=True)
class SingleView:
    """
    A camera, its images and who is in them.

    Attributes
    ----------
    name : str
        Of the scene and the camera.
    mapping : GroundMapping
        Of the camera.
    images : callable
        Yields frame numbers and images.
    truth : Trajectories
        Whom the camera shows.
    period_ns : int
        Of the frames.
    counts : callable
        Tells which (n, 2) positions, m, are where truth is told.
    parts : dict
        First and last frame of what is scored, by name.
    mask, background : (h, w) and (h, w, 3) uint8 arrays, optional
        As `EventTracker` takes them.
    settings : dict
        What a user says about the camera.

    """

    name: str
    mapping: GroundMapping
    images: Callable[[], Iterator[tuple[int, Image]]]
    truth: Trajectories
    period_ns: int
    counts: Callable[[Floats], NDArray[np.bool_]]
    parts: dict[str, tuple[int, int]]
    mask: Image | None = None
    background: Image | None = None
    settings: dict[str, Any] | None = None

    def tracker(self) -> EventTracker:
        """Return the camera's tracker."""
        config = config_from(EventTrackerConfig, self.settings or {})
        return EventTracker(config, self.mapping, self.mask, self.background)

    def stamp_ns(self, frame: int) -> int:
        """Return the stamp of a frame, ns: the middle of its period."""
        return (2 * frame + 1) * self.period_ns // 2


def spread_background(images: Iterator[tuple[int, Image]]) -> Image:
    """Return the median of images spread over a clip."""
    every = [image for _, image in images]
    index = np.linspace(0, len(every) - 1, SPREAD_IMAGES).round().astype(int)
    return np.asarray(np.median([every[i] for i in index], axis=0), np.uint8)


def detected(view: SingleView) -> Trajectories:
    """Return what the camera alone detects, by its local tracks."""
    tracker = view.tracker()
    rows: list[tuple[int, Detections]] = []
    for frame, image in view.images():
        found = tracker.step(image, view.stamp_ns(frame), None).detections
        single = (found.member_count == 1) & np.isfinite(found.position[:, 0])
        rows.append((frame, found.select(single)))
    return Trajectories(
        np.concatenate([np.full(len(found), frame) for frame, found in rows]),
        np.concatenate([found.local_id for _, found in rows]).astype(np.int64),
        np.concatenate([found.position[:, :2] for _, found in rows]).astype(np.float64),
    )


def fused(view: SingleView) -> Trajectories:
    """Return the tracks of the joint tracker, feedback included."""
    tracker = view.tracker()
    buffer = FeedbackBuffer(view.period_ns, 2 * view.period_ns)

    def ticks() -> Iterator[Tick]:
        for frame, image in view.images():
            stamp_ns = view.stamp_ns(frame)
            found = tracker.step(image, stamp_ns, buffer.select(stamp_ns)[0]).detections
            yield Tick.of([CameraDetections('camera', found)])

    config = config_from(JointConfig, {'batching': {'period': view.period_ns * 1e-9}})
    instants = []
    for ticked in drive(config, ('camera',), ticks()):
        assert isinstance(ticked.feedback, Feedback)
        buffer.push(ticked.feedback)
        instants.append(ticked.output.tracks)
    return Trajectories.from_tracks(instants, view.period_ns)


def scored(view: SingleView, tracks: Trajectories) -> dict[str, dict[str, float]]:
    """Return the scores of each part of a scene."""
    tracks = tracks.select(view.counts(tracks.position))
    figures = {}
    for part, (first, last) in view.parts.items():
        frames = [f for f, _ in view.images() if first <= f <= last]
        scores = evaluate_ground(view.truth.at_frames(frames), tracks.at_frames(frames), GATE_M)
        figures[part] = {
            'moda': scores.moda,
            'modp': 1 - scores.mean_distance / GATE_M,
            'recall': scores.recall,
            'precision': scores.precision,
            'mota': scores.mota,
            'idf1': scores.idf1,
            'switches': float(scores.switches),
        }
    return figures


def pets(data: Path) -> SingleView:
    """Return PETS 2009 S2.L1, view 1."""
    folder = data / 'pets2009_s2l1'
    camera = pets_pixels.TsaiCamera(
        folder / 'calibration' / 'View_001.xml', pets_pixels.IMAGE_SIZE
    )
    truth = pets_pixels.read_truth(folder)
    low, high = truth.position.min(axis=0), truth.position.max(axis=0)
    return SingleView(
        'pets',
        camera.mapping,
        lambda: pets_pixels.images(folder, camera),
        truth,
        pets_pixels.PERIOD_NS,
        lambda position: ((position >= low) & (position <= high)).all(axis=1),
        {'tuned': (9, 397), 'held': (398, 795)},
    )


def street(data: Path) -> SingleView:
    """Return TUD-Stadtmitte."""
    folder = data / 'tud_stadtmitte'
    matrix = json.loads((folder / 'ground_H.json').read_text())['feet_px_to_world_m']
    table = np.loadtxt(folder / 'gt' / 'gt.txt', delimiter=',')
    truth = Trajectories(table[:, 0].astype(int), table[:, 1].astype(int), table[:, 7:9])

    def images() -> Iterator[tuple[int, Image]]:
        for file in sorted((folder / 'img1').glob('*.jpg')):
            yield int(file.stem), np.asarray(cv2.imread(str(file)), np.uint8)

    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / 'street.yaml'
        path.write_text(yaml.safe_dump({'ground_from_image': matrix}))
        mapping = read_calibration(path, (640, 480))
    return SingleView(
        'street',
        mapping,
        images,
        truth,
        40_000_000,
        lambda position: np.ones(len(position), bool),
        {'all': (1, 179)},
        background=spread_background(images()),
    )


def terrace4(data: Path, camera: str) -> SingleView:
    """Return a camera of EPFL's terrace, three images a second."""
    files = terrace.image_files(data, camera)
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / 'camera.xml'
        terrace.write_calibration(data, camera, path)
        mapping = read_calibration(path, terrace.SIZE)

    def images() -> Iterator[tuple[int, Image]]:
        for frame, file in files.items():
            yield frame, np.asarray(cv2.imread(str(file)), np.uint8)

    return SingleView(
        f'terrace4.{camera}',
        mapping,
        images,
        terrace.read_identities(data, (camera,)),
        terrace.PERIOD_NS,
        _in_terrace(mapping),
        {'tuned': (75, 1250), 'held': (1251, 2500)},
    )


def terrace_video(data: Path, camera: str) -> SingleView:
    """Return a video of EPFL's terrace, without what its logo covers."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / 'camera.xml'
        terrace.write_calibration(data, camera, path)
        mapping = read_calibration(path, terrace.SIZE)

    def images() -> Iterator[tuple[int, Image]]:
        video = open_video(terrace_videos.video(data, camera))
        for frame, image in enumerate(video.images(), start=1):
            if frame > 2500:
                break
            yield frame, image

    return SingleView(
        f'terrace.{camera}',
        mapping,
        images,
        terrace.read_identities(data, (camera,)),
        terrace.PERIOD_NS,
        _in_terrace(mapping),
        {'tuned': (100, 1250), 'held': (1251, 2500)},
        mask=terrace_videos.watermark_mask(),
    )


def _in_terrace(mapping: GroundMapping) -> Callable[[Floats], NDArray[np.bool_]]:
    def counts(position: Floats) -> NDArray[np.bool_]:
        foot = mapping.image_from_ground(position)
        with np.errstate(invalid='ignore'):
            whole = (foot[:, 1] < terrace.CUT_OFF_PX) & (foot[:, 0] >= 0)
            whole &= foot[:, 0] < terrace.SIZE[0]
        return np.asarray(whole & inside(position, terrace.AREA))

    return counts


def pitch(cache: Path, camera: str, seed: int) -> SingleView:
    """Return a camera of a simulated match, whose images stay in the cache."""
    folder = cache / f'pitch_match_{seed}'
    folder.mkdir(parents=True, exist_ok=True)
    world = World.simulated(Scenario(seed=seed, duration_s=PITCH_S))
    site = with_backgrounds(load_site(config_file('pitch5.yaml')), world, folder)
    if not (folder / 'match').exists():
        simulate(world.scenario, folder / 'match', world=world)
    period_ns = round(1e9 / world.scenario.rate_hz)
    begin_ns = world.scenario.stamp_ns(0) - period_ns // 2
    mapping = site.cameras[camera].mapping()
    background = np.asarray(cv2.imread(str(site.cameras[camera].background)), np.uint8)
    step, person = np.nonzero(world.active)
    position = world.motion.position[step, person]
    seen = _in_image(mapping, position)
    truth = Trajectories(step[seen], person[seen] + 1, position[seen])

    def images() -> Iterator[tuple[int, Image]]:
        with BagReader(folder / 'match') as bag:
            topics = [f'/{camera}/image_raw/compressed']
            for _, message, _ in bag.messages(topics):
                stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
                yield (stamp - begin_ns) // period_ns, image_from_message(message)

    return SingleView(
        f'pitch{seed}.{camera}',
        mapping,
        images,
        truth,
        period_ns,
        lambda position: _in_image(mapping, position),
        {'all': (0, 10**6)},
        background=background,
    )


def _in_image(mapping: GroundMapping, position: Floats) -> NDArray[np.bool_]:
    """Tell who is seen in the image, neither cut off by its edge nor too far away."""
    foot, head = (mapping.image_from_ground(position, height) for height in (0.0, 1.7))
    width, height = mapping.image_size
    with np.errstate(invalid='ignore'):
        return np.asarray(
            (foot[:, 0] > 3) & (foot[:, 0] < width - 3) & (foot[:, 1] < height - 1)
            & (head[:, 1] >= 0) & (foot[:, 1] - head[:, 1] >= 9)
        )  # fmt: skip


def views(data: Path, cache: Path) -> dict[str, Callable[[], SingleView]]:
    """Return how to open each scene, by name."""
    found: dict[str, Callable[[], SingleView]] = {
        'pets': partial(pets, data),
        'street': partial(street, data),
    }
    for camera in terrace.CAMERAS:
        found[f'terrace4.{camera}'] = partial(terrace4, data, camera)
    for camera in terrace_videos.CAMERAS:
        found[f'terrace.{camera}'] = partial(terrace_video, data, camera)
    for camera in ('cam1', 'cam3'):
        found[f'pitch1.{camera}'] = partial(pitch, cache, camera, 1)
    return found


def main() -> None:
    """Print a row for each part of each scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('data', type=Path)
    parser.add_argument('--cache', type=Path, required=True)
    parser.add_argument('--only', nargs='*', default=[''])
    parser.add_argument('--fused', action='store_true')
    options = parser.parse_args()
    for name, open_view in views(options.data, options.cache).items():
        if not any(name.startswith(one) for one in options.only):
            continue
        view = open_view()
        tracks = fused(view) if options.fused else detected(view)
        for part, figures in scored(view, tracks).items():
            row = ' '.join(f'{key} {value:6.3f}' for key, value in figures.items())
            print(f'{name:12} {part:6} {row}', flush=True)


if __name__ == '__main__':
    main()
