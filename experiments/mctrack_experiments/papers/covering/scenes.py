"""The scenes: what the cameras of each detect, made once and without feedback, and the truth."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_experiments.datasets.lab6p import load_lab6p
from mctrack_experiments.datasets.stored import StoredScene, stamp_of
from mctrack_experiments.papers.event_tracking.tracked_match import with_backgrounds
from mctrack_experiments.real import pets_pixels
from mctrack_experiments.real.terrace import videos as terrace
from mctrack_ros.codec import jpeg_from_image
from mctrack_ros.config import config_from, values_of
from mctrack_ros.evaluation import Trajectories
from mctrack_ros.fusion import JointConfig
from mctrack_ros.interfaces import Detections
from mctrack_ros.perception import EventTracker, EventTrackerConfig
from mctrack_ros.perception.trackers import CameraTracker
from mctrack_ros.recording.video.videos import open_video
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import CARPARK, PITCH5, CarParkScenario, Scenario, World
from mctrack_ros.simulation.world import feet_in_view
from mctrack_ros.site.site import SiteConfig, load_site

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Image = NDArray[np.uint8]

PITCH_S, CARPARK_S, TERRACE_S = 30.0, 240.0, 60.0
"""How much of each is played, s."""
TERRACE_HZ = 25.0
PITCH_GATE_M, CARPARK_GATE_M = 1.0, 2.0
"""Of a match with the truth; the place of a car is its middle, m."""
NOBODY = Trajectories(np.empty(0, np.int64), np.empty(0, np.int64))


@dataclass(frozen=True, eq=False, slots=True)
class CoveringScene:
    """
    What every tracker is given, and what it is held against.

    Attributes
    ----------
    stored : StoredScene
        Detections and truth; the truth of all people in the area.
    fusion : JointConfig
        As the scene's site has it.
    gate_m : float
        Of a match with the truth, m.
    area : callable
        Tells of (n, 2) places, m, which are watched by some of the named cameras.
    frames : (n,) int64 array
        Those that are scored.
    camera_ms : float
        Processor time of the images of a tick of all cameras, ms; 0: not known.

    """

    stored: StoredScene
    fusion: JointConfig
    gate_m: float
    area: Callable[[Floats, tuple[str, ...]], Mask]
    frames: NDArray[np.int64]
    camera_ms: float = 0.0

    def truth(self, cameras: tuple[str, ...]) -> Trajectories:
        """Return the true people at the scored instants whom some of the cameras could see."""
        return self._watched(self.stored.truth, cameras)

    def scored(self, tracks: Trajectories, cameras: tuple[str, ...]) -> Trajectories:
        """Return the rows of tracks that are held against the truth."""
        return self._watched(tracks, cameras)

    def _watched(self, rows: Trajectories, cameras: tuple[str, ...]) -> Trajectories:
        rows = rows.at_frames(self.frames)
        return rows.select(self.area(rows.position, cameras)) if len(rows) else rows


def everywhere(place: Floats, cameras: tuple[str, ...]) -> Mask:
    """Return that all places are watched."""
    return np.ones(len(place), np.bool_)


def pitch(seed: int, cameras: tuple[str, ...], seconds: float = PITCH_S) -> CoveringScene:
    """Play a match before some of the pitch's cameras; their backgrounds are given."""
    world = PITCH5.world(Scenario(seed=seed, duration_s=seconds))
    with tempfile.TemporaryDirectory() as folder:
        site = with_backgrounds(load_site(config_file('pitch5.yaml')), world, Path(folder))
        trackers = {name: site.cameras[name].open(name) for name in cameras}
    return _simulated(world, site, trackers, PITCH_GATE_M)


def carpark(seed: int, seconds: float = CARPARK_S) -> CoveringScene:
    """Play a recording of the car park; its camera tracks by silhouettes."""
    world = CARPARK.world(CarParkScenario(seed=seed, duration_s=seconds))
    site = load_site(config_file('carpark.yaml'))
    return _simulated(world, site, {'cam1': site.cameras['cam1'].open('cam1')}, CARPARK_GATE_M)


def pets(data: Path) -> CoveringScene:
    """Return PETS 2009 S2.L1, view 1, from its video; frames 398 to 795 are scored."""
    folder = data / 'pets2009_s2l1'
    camera = pets_pixels.TsaiCamera(
        folder / 'calibration' / 'View_001.xml', pets_pixels.IMAGE_SIZE
    )
    images = (image for _, image in pets_pixels.images(folder, camera))
    rate = 1 / pets_pixels.PERIOD_S
    rows, spent_ms = _detected(EventTracker(EventTrackerConfig(), camera.mapping), images, rate)
    truth = pets_pixels.read_truth(folder)
    low, high = truth.position.min(axis=0), truth.position.max(axis=0)
    first, last = pets_pixels.REPORTED_FRAMES
    return CoveringScene(
        StoredScene(np.arange(1, len(rows) + 1), rate, {pets_pixels.CAMERA: rows}, truth),
        config_from(JointConfig, {'batching': {'period': pets_pixels.PERIOD_S}}),
        pets_pixels.GATE_M,
        lambda place, cameras: ((place >= low) & (place <= high)).all(axis=1),
        np.arange(first, last + 1),
        spent_ms,
    )


def terrace_clips(data: Path) -> CoveringScene:
    """Return the beginning of EPFL's terrace, two cameras; there is no truth."""
    with tempfile.TemporaryDirectory() as folder:
        site = terrace.write_site(data, Path(folder))
        trackers = {name: site.cameras[name].open(name) for name in terrace.CAMERAS}
    count, spent_ms, detections = round(TERRACE_S * TERRACE_HZ), 0.0, {}
    for name, tracker in trackers.items():
        images = islice(open_video(terrace.video(data, name)).images(), count)
        detections[name], own_ms = _detected(tracker, images, TERRACE_HZ)
        spent_ms += own_ms
    frames = np.arange(min(map(len, detections.values())))
    stored = StoredScene(frames, TERRACE_HZ, detections, NOBODY)
    assert isinstance(site.fusion, JointConfig)
    return CoveringScene(stored, site.fusion, 1.0, everywhere, frames, spent_ms)


def lab6p(data: Path) -> CoveringScene:
    """Return EPFL's six people, whose detections others made: association alone."""
    stored = load_lab6p(data / 'epfl_lab6p', 'proposed_confirmed', 2.0)
    fusion = _with(JointConfig(), {'batching.period': 1 / stored.rate})
    return CoveringScene(stored, fusion, 0.5, everywhere, np.unique(stored.truth.frame))


def _with(config: JointConfig, settings: Mapping[str, float | str]) -> JointConfig:
    """Return a configuration with values changed by dotted name."""
    values = values_of(config)
    for name, value in settings.items():
        part, field = name.split('.')
        values[part][field] = value
    return config_from(JointConfig, values)


def _simulated(
    world: World, site: SiteConfig, trackers: Mapping[str, CameraTracker], gate_m: float
) -> CoveringScene:
    """Show what goes on to cameras of a simulated scene."""
    scene = CARPARK if site.name == 'carpark' else PITCH5
    by_name = {camera.name: camera for camera in world.cameras}
    rate, spent_ms, detections = world.scenario.rate_hz, 0.0, {}
    for name, tracker in trackers.items():
        renderer = scene.renderer(world, list(by_name).index(name))
        images = (_received(renderer.frame(step)[0]) for step in range(world.scenario.steps))
        detections[name], own_ms = _detected(tracker, images, rate)
        spent_ms += own_ms

    def area(place: Floats, cameras: tuple[str, ...]) -> Mask:
        watching = tuple(by_name[name] for name in cameras)
        return np.asarray(feet_in_view(place[None], watching)[0].any(axis=0))

    step, person = np.nonzero(world.active)
    truth = Trajectories(step, person + 1, world.motion.position[step, person])
    frames = np.arange(world.scenario.steps)
    stored = StoredScene(frames, rate, detections, truth)
    assert isinstance(site.fusion, JointConfig)
    return CoveringScene(stored, site.fusion, gate_m, area, frames, spent_ms)


def _received(image: Image) -> Image:
    """Return an image as it comes out of its JPEG."""
    return np.asarray(cv2.imdecode(jpeg_from_image(image), cv2.IMREAD_COLOR), np.uint8)


def _detected(
    tracker: CameraTracker, images: Iterable[Image], rate: float
) -> tuple[list[Detections], float]:
    """Return what one camera detects without feedback, and its processor time an image, ms."""
    rows, spent_s = [], 0.0
    for index, image in enumerate(images):
        began = time.process_time()
        rows.append(tracker.step(image, stamp_of(index, rate), None).detections)
        spent_s += time.process_time() - began
    return rows, 1e3 * spent_s / max(len(rows), 1)
