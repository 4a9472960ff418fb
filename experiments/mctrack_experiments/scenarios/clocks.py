"""Cameras whose clocks differ: what the time-sync doctor makes of it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from mctrack_experiments.bench.workers import run_spread
from mctrack_experiments.real.terrace import videos as terrace_videos
from mctrack_experiments.real.terrace.four_cameras import IMAGES_S, write_images, write_site
from mctrack_experiments.scenarios.staged.stage import merged
from mctrack_ros.cli.sites import named_site
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.clock_offsets.clock_offsets import ClockOffset, ClockOffsets
from mctrack_ros.interfaces import CameraDetections, Detections, Tick
from mctrack_ros.recording import BagReader
from mctrack_ros.recording.video.videos import open_video
from mctrack_ros.replay.drive import drive
from mctrack_ros.replay.track import track_bag
from mctrack_ros.simulation import Camera, Scenario, pitch5_cameras
from mctrack_ros.simulation.pitch.players import simulate_motion
from mctrack_ros.simulation.recording import simulate

Floats = NDArray[np.float64]
Messages = Mapping[str, Sequence[Detections]]

SECONDS = 60.0
OFFSETS_S = (0.0, 0.02, 0.05, 0.12)
NEAR_S = 0.005
WINDOW_S = 600.0
NOISE_PX = (0.75, 0.65)
"""Standard deviation of foot points of the camera node on the rendered pitch, across and down, px
(seed 50; robust: of what is not an outlier)."""
PARTS = ((0.3, 0.0), (0.2, 0.25), (0.35, 1.5), (0.15, 60.0))
"""Shares of their variance, and for how long each lasts, s: the autocorrelation of the same."""
OUTLIERS, OUTLIER = 0.03, 5.0
"""Share of lasting errors that are so many times as large: occlusions."""
STATED_PX = 1.5
"""What the covariances of detections say, px."""
BIAS_M = 0.1
"""Standard deviation, along each axis, of what a calibration is off by, m."""
DETECTED = 0.92
PERIOD_NS = 40_000_000


def detected(scenario: Scenario, standing: bool = False) -> Messages:
    """
    Return what each camera of the pitch detects, image by image.

    Noise is that of foot points on rendered images; who is hidden by somebody in front makes one
    detection with him.

    Parameters
    ----------
    scenario : Scenario
        The match.
    standing : bool
        Whether nobody moves.

    """
    rng = np.random.default_rng([scenario.seed, 7])
    place = simulate_motion(scenario).position
    if standing:
        place = np.repeat(place[:1], len(place), axis=0)
    cameras = pitch5_cameras(scenario)
    return {camera.name: _detected(camera, scenario, place, rng) for camera in cameras}


def _detected(
    camera: Camera, scenario: Scenario, place: Floats, rng: np.random.Generator
) -> list[Detections]:
    world = np.concatenate([place, np.zeros((*place.shape[:2], 1))], axis=2)
    pixel = camera.project(world)
    noise = sum(
        (_lasting(rng, pixel.shape, share, seconds) for share, seconds in PARTS),
        np.zeros(pixel.shape),
    ) * np.array(NOISE_PX)
    shown = camera.ground(pixel + noise) + rng.normal(0.0, BIAS_M, 2)
    step = 0.5 * np.eye(2)
    slope = np.stack([camera.ground(pixel + d) - camera.ground(pixel - d) for d in step], axis=-1)
    covariance = STATED_PX**2 * slope @ np.swapaxes(slope, -1, -2)
    seen = camera.sees(world) & (rng.random(pixel.shape[:2]) < DETECTED)
    rows = []
    for tick, who in enumerate(seen):
        target, other, shift = merged(place[tick], np.flatnonzero(who), camera.position[:2])
        at = np.column_stack([shown[tick, target] + shift, np.zeros(len(target))])
        rows.append(
            Detections.build(
                scenario.stamp_ns(tick),
                position=at,
                covariance=covariance[tick, target],
                member_count=np.where(other >= 0, 2, 1),
            )
        )
    return rows


def _lasting(
    rng: np.random.Generator, shape: tuple[int, ...], share: float, seconds: float
) -> Floats:
    """Return noise that lasts for some time; now and then it is much larger."""
    keep = np.exp(-PERIOD_NS * 1e-9 / seconds) if seconds else 0.0
    fresh = rng.normal(size=shape) * np.sqrt(1 - keep**2)
    fresh[0] = rng.normal(size=shape[1:])
    noise = np.sqrt(share) * lfilter([1.0], [1.0, -keep], fresh, axis=0)
    if 0 < seconds < SECONDS:
        often = lfilter([1.0], [1.0, -keep], rng.normal(size=shape[:2]), axis=0)
        limit = np.quantile(often, 1 - OUTLIERS)
        noise[often > limit] *= OUTLIER
    return np.asarray(noise)


def ticks_of(
    messages: Messages, ahead_s: Mapping[str, float], period_ns: int = PERIOD_NS
) -> Iterator[Tick]:
    """Yield what fusion is given while clocks are ahead, s."""
    periods: dict[int, list[CameraDetections]] = {}
    for camera, images in messages.items():
        for rows in images:
            stamped = rows.at(rows.stamp_ns + round(ahead_s.get(camera, 0.0) * 1e9))
            own = periods.setdefault(stamped.stamp_ns // period_ns, [])
            own.append(CameraDetections(camera, stamped))
    for _, own in sorted(periods.items()):
        yield Tick.of(own)


def estimated(
    messages: Messages, ahead_s: Mapping[str, float], period_ns: int = PERIOD_NS
) -> dict[str, ClockOffset]:
    """Fuse what cameras detect, and estimate their clocks' offsets by the tracks; by camera."""
    cameras, config = tuple(messages), JointConfig()
    batching = replace(config.batching, period=period_ns * 1e-9)
    offsets = ClockOffsets(cameras, WINDOW_S)
    ticks = ticks_of(messages, ahead_s, period_ns)
    for ticked in drive(replace(config, batching=batching), cameras, ticks):
        offsets.add(ticked.tick, ticked.output.tracks)
    return {one.camera: one for one in offsets.estimate()}


class Trial(NamedTuple):
    """
    One estimate beside the truth.

    Attributes
    ----------
    is_shifted : bool
        Whether it is of the camera whose clock is ahead; else of another.
    ahead_s, error_s, half_s : float
        By how much that one is, the error, and half the interval, s.

    """

    is_shifted: bool
    ahead_s: float
    error_s: float
    half_s: float


def reproduce_clocks(
    data: Path,
    seeds: Sequence[int],
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Figures:
    """
    Let one camera's clock be ahead, in matches and on the terrace, and measure it.

    Parameters
    ----------
    data : Path
        Folder of the real data.
    seeds : sequence of int
        One match for each; which camera, and by how much, follows from its place.
    progress : callable
        Told how many matches are done, of how many.

    """
    trials = [one for own in run_spread(_trials, list(enumerate(seeds)), progress) for one in own]
    shifted = [one for one in trials if one.is_shifted]
    figures = {
        'coverage': _covered(shifted),
        'coverage_all': _covered(trials),
        'half_ms': 1e3 * float(np.median([one.half_s for one in trials])),
        'within_5ms': float(np.mean([abs(one.error_s) <= NEAR_S for one in shifted])),
    }
    for ahead_s in OFFSETS_S:
        errors = 1e3 * np.abs([one.error_s for one in shifted if one.ahead_s == ahead_s])
        name = f'offset_{round(1e3 * ahead_s)}ms'
        figures[f'{name}.rms_ms'] = float(np.sqrt((errors**2).mean()))
        figures[f'{name}.worst_ms'] = float(errors.max())
    still = estimated(detected(Scenario(seed=seeds[0], duration_s=SECONDS), standing=True), {})
    figures['still.known'] = sum(one.is_known for one in still.values() if _is_beside(one))
    with tempfile.TemporaryDirectory(prefix='mctrack_clocks_') as name:
        folder = Path(name)
        figures |= _shifts('pixels', _rendered(seeds[0], folder), PERIOD_NS)
        figures |= _shifts('terrace4', _terrace4(data, folder), round(IMAGES_S * 1e9))
        figures |= _shifts('terrace', _terrace(data, folder), PERIOD_NS)
    return Figures('clocks', 'mctrack reproduce clocks', _protocol(seeds), figures)


def _is_beside(one: ClockOffset) -> bool:
    return one.camera != one.reference


def _covered(trials: Sequence[Trial]) -> float:
    return float(np.mean([abs(one.error_s) <= one.half_s for one in trials]))


def _trials(job: tuple[int, int]) -> list[Trial]:
    """Estimate in one match; the camera that is the reference has no error."""
    index, seed = job
    ahead_s = OFFSETS_S[index % len(OFFSETS_S)]
    messages = detected(Scenario(seed=seed, duration_s=SECONDS))
    camera = list(messages)[index // len(OFFSETS_S) % len(messages)]
    found, trials = estimated(messages, {camera: ahead_s}), []
    if found[camera].reference == camera:  # as good as any: measure the others from it
        trials.append(_against(found, camera, ahead_s))
    for one in filter(_is_beside, found.values()):
        true_s = ahead_s * ((one.camera == camera) - (one.reference == camera))
        error_s = one.offset_s - true_s
        trials.append(Trial(one.camera == camera, ahead_s, error_s, one.half_s))
    return trials


def _against(found: Mapping[str, ClockOffset], camera: str, ahead_s: float) -> Trial:
    """Return the trial of a reference: it and the camera that is known best beside it."""
    others = [one for one in found.values() if one.camera != camera]
    best = min(others, key=lambda one: (one.half_s, one.camera))
    return Trial(True, ahead_s, -best.offset_s - ahead_s, best.half_s)


def _rendered(seed: int, folder: Path) -> Messages:
    """Render a match, and detect in its images with the shipped site."""
    site = named_site('pitch5')
    simulate(Scenario(seed=seed, duration_s=SECONDS), folder / 'pitch')
    track_bag(folder / 'pitch', folder / 'pitch_out', site)
    return _told(folder / 'pitch_out', site.camera_names)


def _terrace4(data: Path, folder: Path) -> Messages:
    (folder / 'terrace4').mkdir()
    write_images(data, folder / 'terrace4' / 'bag')
    site = write_site(data, folder / 'terrace4', 'joint')
    track_bag(folder / 'terrace4' / 'bag', folder / 'terrace4_out', site)
    return _told(folder / 'terrace4_out', site.camera_names)


def _terrace(data: Path, folder: Path) -> Messages:
    (folder / 'terrace').mkdir()
    videos = {
        name: open_video(terrace_videos.video(data, name)) for name in terrace_videos.CAMERAS
    }
    site = terrace_videos.write_site(data, folder / 'terrace')
    track_bag(videos, folder / 'terrace_out', site)
    return _told(folder / 'terrace_out', site.camera_names)


def _told(out: Path, cameras: Sequence[str]) -> Messages:
    """Return the detections that a run wrote."""
    with BagReader(out / 'bag') as reader:
        return {
            name: [rows for rows, _ in reader.rows(f'/{name}/detections', Detections)]
            for name in cameras
        }


def _shifts(name: str, messages: Messages, period_ns: int) -> dict[str, float]:
    """Shift the stamps of the second camera; return what changes beside what should."""
    beside, own, *_ = messages

    def measured(ahead_s: float) -> tuple[float, float]:
        found = estimated(messages, {own: ahead_s}, period_ns)
        half_s = max(found[camera].half_s for camera in (own, beside))
        return found[own].offset_s - found[beside].offset_s, half_s

    before_s, half_s = measured(0.0)
    figures = {f'{name}.unshifted_ms': 1e3 * before_s, f'{name}.half_ms': 1e3 * half_s}
    changes = [
        (1e3 * shift_s, 1e3 * (measured(shift_s)[0] - before_s)) for shift_s in OFFSETS_S[1:]
    ]
    errors = [abs(change - shift) for shift, change in changes]
    return figures | {f'{name}.change_error_worst_ms': max(errors)}


def _protocol(seeds: Sequence[int]) -> dict[str, str]:
    ahead = ', '.join(f'{1e3 * ahead_s:g}' for ahead_s in OFFSETS_S)
    return {
        'trials': f'{len(seeds)} matches of {SECONDS:g} s, seeds {min(seeds)} to {max(seeds)}, '
        '25 people, five cameras, detections of the simulator with noise; association by the '
        'joint tracker by default, at the wrong stamps',
        'noise': f'of feet, as on rendered images: {NOISE_PX[0]:g} and {NOISE_PX[1]:g} px, most '
        f'of it for 0.25 s to a minute, {OUTLIERS:.0%} occlusions {OUTLIER:g} times as large; '
        f'calibrations off by {BIAS_M:g} m',
        'offset_N': f'one camera in turn is ahead by 0, 20, 50 or 120 ms ({ahead}); rms and '
        'largest error after 60 s against the reference, the camera in the middle',
        'coverage': 'share of the trials in whose 95 % interval the truth lies; all: of all '
        'cameras',
        'within_5ms': 'share of the trials',
        'still': 'cameras whose offset counts as known while nobody moves',
        'pixels': 'the first match rendered and detected in images; the second camera shifted',
        'terrace4, terrace': 'detections of four cameras at 3 Hz and two at 25 Hz, from images; '
        'the second camera shifted by the same; unshifted: what is measured between it and the '
        'first before, half: half its 95 % interval; change_error: measured change less the shift',
    }
