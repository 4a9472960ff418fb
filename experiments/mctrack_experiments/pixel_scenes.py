"""Scenes whose detections come from pixels: cameras see them once, fusion tracks them again."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_experiments.datasets.epfl_terrace import (
    CAMERAS,
    PERIOD_NS,
    image_files,
    metres_from_top_view,
    read_identities,
    read_positions,
)
from mctrack_experiments.papers.event_tracking.tracked_match import with_backgrounds
from mctrack_experiments.real import pets_pixels
from mctrack_experiments.real.terrace import four_cameras as terrace4
from mctrack_experiments.real.terrace import videos as terrace
from mctrack_experiments.scenarios.hall import ground_scores
from mctrack_ros.config import config_from
from mctrack_ros.evaluation import Trajectories, evaluate_ground
from mctrack_ros.fusion import JointConfig, OpenViews
from mctrack_ros.fusion.trackers import no_views
from mctrack_ros.interfaces import CameraDetections, Detections, Feedback, Tick, Tracks
from mctrack_ros.perception import EventTracker, EventTrackerConfig, FeedbackBuffer
from mctrack_ros.recording import BagReader, BagWriter
from mctrack_ros.recording.video.videos import START_NS, open_video
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.recorded import recorded_ticks
from mctrack_ros.replay.track import track_bag
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import HallScenario, Scenario, World
from mctrack_ros.simulation.indoor import hall
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.site import SiteConfig, load_site

FIGURES = ('mota', 'idf1', 'switches')
PITCH_S, HALL_S = 30.0, 30.0
PITCH_SEEDS = range(1, 5)
"""Of the matches 1 to 6 that the tracker may be tuned on."""
GATE_M = 1.0

Changes = Mapping[str, Any]
Scores = dict[str, float]
GROUND_FRAME = 'map'


@dataclass(frozen=True)
class PixelScene:
    """
    Images, how they are tracked, and how tracks of them are scored.

    Attributes
    ----------
    name : str
        Of its folder in the cache.
    cameras : tuple of str
        In the site's order.
    fusion : JointConfig
        As the scene's site has it.
    track : callable
        Runs cameras and fusion with some changes, and writes detections and tracks as the bag
        ``bag`` into a folder.
    score : callable
        Scores the tracks of all ticks.
    views : callable
        How the cameras see the ground, for trackers that have to know.

    """

    name: str
    cameras: tuple[str, ...]
    fusion: JointConfig
    track: Callable[[JointConfig, Path], None]
    score: Callable[[Iterable[Tracks]], Scores]
    views: OpenViews = no_views

    def closed_loop(self, changes: Changes, folder: Path) -> Scores:
        """Return the scores where the cameras, too, are run with the changes."""
        self.track(changed(self.fusion, changes), folder)
        with BagReader(folder / 'bag') as bag:
            return self.score([rows for rows, _ in bag.rows('/tracks', Tracks)])

    def ticks(self, cache: Path) -> list[Tick]:
        """Return what the cameras detect, with feedback of the fusion as it is; made once."""
        if not (cache / self.name / 'bag').exists():
            self.track(self.fusion, cache / self.name)
        ticks: dict[int, list[CameraDetections]] = defaultdict(list)
        period_ns = round(self.fusion.batching.period * 1e9)
        with BagReader(cache / self.name / 'bag') as bag:
            for camera in self.cameras:
                for rows, _ in bag.rows(f'/{camera}/detections', Detections):
                    ticks[rows.stamp_ns // period_ns].append(CameraDetections(camera, rows))
        return [Tick.of(ticks[index]) for index in sorted(ticks)]

    def fused_again(self, changes: Changes, cache: Path) -> Scores:
        """Return the scores of fusion, with some changes, of all that cameras sent; made once."""
        if not (cache / self.name / 'bag').exists():
            self.track(self.fusion, cache / self.name)
        config = changed(self.fusion, changes)
        with BagReader(cache / self.name / 'bag') as bag:
            ticks = recorded_ticks(bag, self.cameras, config)
            driven = drive(config, self.cameras, ticks, views=self.views)
            return self.score([ticked.output.tracks for ticked in driven])

    def fused(self, ticks: Iterable[Tick], changes: Changes) -> Scores:
        """Return the scores of fusion alone, with some changes."""
        config = changed(self.fusion, changes)
        driven = drive(config, self.cameras, ticks)
        return self.score([ticked.output.tracks for ticked in driven])


def changed(config: Any, changes: Changes) -> Any:
    """Return a configuration with values changed by dotted name."""
    for name, value in changes.items():
        part, _, rest = name.partition('.')
        own = changed(getattr(config, part), {rest: value}) if rest else value
        config = replace(config, **{part: own})
    return config


def disturbed(ticks: Iterable[Tick], sigma_m: float, seed: int) -> Iterator[Tick]:
    """Yield the same ticks, every detection moved at random along each axis, m."""
    random = np.random.default_rng(seed)
    for tick in ticks:
        messages = []
        for message in tick.messages:
            position = message.rows.position.copy()
            position[:, :2] += random.normal(0.0, sigma_m, (len(position), 2))
            rows = message.rows.replace(position=position)
            messages.append(CameraDetections(message.camera, rows))
        yield Tick.of(messages)


def pitch(seed: int, cache: Path) -> PixelScene:
    """Return a match, whose cameras know the empty pitch; its images stay in the cache."""
    folder = cache / f'pitch_match_{seed}'
    folder.mkdir(parents=True, exist_ok=True)
    world = World.simulated(Scenario(seed=seed, duration_s=PITCH_S))
    site = with_backgrounds(load_site(config_file('pitch5.yaml')), world, folder)
    step, person = np.nonzero(world.active)
    truth = Trajectories(step, person + 1, world.motion.position[step, person])

    def track(fusion: JointConfig, out: Path) -> None:
        if not (folder / 'match').exists():
            simulate(world.scenario, folder / 'match', world=world)
        track_bag(folder / 'match', out, replace(site, fusion=fusion), overwrite=True)

    def score(instants: Iterable[Tracks]) -> Scores:
        period_ns = round(1e9 / world.scenario.rate_hz)
        begin_ns = world.scenario.stamp_ns(0) - period_ns // 2
        tracks = Trajectories.from_tracks(instants, period_ns, begin_ns)
        scores = evaluate_ground(truth, tracks, GATE_M)
        return {name: float(getattr(scores, name)) for name in FIGURES}

    return _scene(f'pitch_{seed}', site, track, score)


def four_terrace_cameras(
    data: Path, cache: Path, run: int = 0, tracker: str = 'joint'
) -> PixelScene:
    """
    Return EPFL's terrace, four cameras from image `run` on, frames that may be tuned on.

    Its default tracker, with ``tracker=''``, takes masks, not detections.
    """
    folder = cache / f'terrace4_site_{run}'
    folder.mkdir(parents=True, exist_ok=True)
    site = terrace4.write_site(data, folder, tracker)
    positions, identities = read_positions(data), read_identities(data, CAMERAS)
    frames = [frame for frame in image_files(data, CAMERAS[0]) if _is_tuned_on(frame)]

    def track(fusion: JointConfig, out: Path) -> None:
        if not (folder / 'bag').exists():
            terrace4.write_images(data, folder / 'bag', run)
        track_bag(folder / 'bag', out, replace(site, fusion=fusion), overwrite=True)

    def score(instants: Iterable[Tracks]) -> Scores:
        tracks = Trajectories.from_tracks(instants, PERIOD_NS, START_NS)
        return _named(terrace4.scored(tracks, positions, identities, frames))

    return _scene(f'terrace4_{run}', site, track, score)


def terrace_videos(data: Path, cache: Path) -> PixelScene:
    """Return EPFL's terrace, videos of two cameras, frames that may be tuned on."""
    folder = cache / 'terrace_site'
    folder.mkdir(parents=True, exist_ok=True)
    site = terrace.write_site(data, folder)
    positions, identities = read_positions(data), read_identities(data, terrace.CAMERAS)
    frames = range(terrace4.FIRST_OF_VIDEO, terrace4.TUNED_TO + 1)

    def track(fusion: JointConfig, out: Path) -> None:
        videos = {name: open_video(terrace.video(data, name)) for name in terrace.CAMERAS}
        track_bag(videos, out, replace(site, fusion=fusion), overwrite=True)

    def score(instants: Iterable[Tracks]) -> Scores:
        tracks = Trajectories.from_tracks(instants, PERIOD_NS, START_NS - PERIOD_NS)
        top_view_px = tracks.position / terrace.METRES_PER_TOP_VIEW_PX
        tracks = replace(tracks, position=metres_from_top_view(top_view_px))
        return _named(terrace4.scored(tracks, positions, identities, frames))

    return _scene('terrace', site, track, score)


def pets(data: Path) -> PixelScene:
    """Return PETS 2009 S2.L1, view 1, frames that may be tuned on."""
    folder = data / 'pets2009_s2l1'
    truth = pets_pixels.read_truth(folder)
    frames = 1, pets_pixels.REPORTED_FRAMES[0] - 1
    camera = pets_pixels.TsaiCamera(
        folder / 'calibration' / 'View_001.xml', pets_pixels.IMAGE_SIZE
    )

    def track(fusion: JointConfig, out: Path) -> None:
        tracker = EventTracker(EventTrackerConfig(), camera.mapping)
        buffer = FeedbackBuffer(pets_pixels.PERIOD_NS, pets_pixels.FEEDBACK_DELAY_NS)

        def ticks() -> Iterator[Tick]:
            for frame, image in pets_pixels.images(folder, camera):
                stamp_ns = pets_pixels.stamp_of(frame)
                rows = tracker.step(image, stamp_ns, buffer.select(stamp_ns)[0]).detections
                yield Tick.of([CameraDetections(pets_pixels.CAMERA, rows)])

        with BagWriter(out / 'bag', overwrite=True) as bag:
            for ticked in drive(fusion, (pets_pixels.CAMERA,), ticks()):
                assert isinstance(ticked.feedback, Feedback)
                buffer.push(ticked.feedback)
                (message,) = ticked.tick.messages
                bag.write_rows(f'/{message.camera}/detections', message.rows, GROUND_FRAME)
                bag.write_rows('/tracks', ticked.output.tracks, GROUND_FRAME)

    def score(instants: Iterable[Tracks]) -> Scores:
        scores = pets_pixels.score(instants, truth, frames)
        return {name: float(getattr(scores, name)) for name in FIGURES}

    fusion = config_from(JointConfig, {'batching': {'period': pets_pixels.PERIOD_S}})
    return PixelScene('pets_pixels', (pets_pixels.CAMERA,), fusion, track, score)


def hall_masks(seed: int, cache: Path) -> PixelScene:
    """Return people close by in a hall with shadows, four cameras; images stay in the cache."""
    scenario = HallScenario(seed=seed, duration_s=HALL_S, shadows=True)
    world, folder = hall.hall_world(scenario), cache / f'hall_match_{seed}'

    def track(fusion: JointConfig, out: Path) -> None:
        if not folder.exists():
            simulate(scenario, folder, world=world)
        track_bag(folder, out, replace(site, fusion=fusion), overwrite=True)

    def score(instants: Iterable[Tracks]) -> Scores:
        scores = ground_scores(world, list(instants))
        return {name: scores[f'{name}_0.5m'] for name in FIGURES}

    site, _ = with_tracker(load_site(config_file('hall.yaml')))
    return _scene(f'hall_{seed}', site, track, score)


def _scene(
    name: str,
    site: SiteConfig,
    track: Callable[[JointConfig, Path], None],
    score: Callable[[Iterable[Tracks]], Scores],
) -> PixelScene:
    assert isinstance(site.fusion, JointConfig)
    return PixelScene(name, site.camera_names, site.fusion, track, score, site.views)


def _is_tuned_on(frame: int) -> bool:
    return terrace4.FIRST_IMAGE <= frame <= terrace4.TUNED_TO


def _named(scores: Scores) -> Scores:
    return {name: float(scores[name]) for name in FIGURES}
