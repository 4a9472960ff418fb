"""Track a bag or videos offline: tracks, events and feedback as a bag, and as text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mctrack_ros.fusion.camera_clocks import Jump
from mctrack_ros.fusion.joint_tracker.output import FusionOutput
from mctrack_ros.fusion.sensor_bias.camera_bias import CameraBias
from mctrack_ros.fusion.trackers import START_TOPIC
from mctrack_ros.interfaces import REPORTED, Detections
from mctrack_ros.recording import BagReader, stated_origin
from mctrack_ros.replay.camera_source import CameraTask, Debug, topic_of
from mctrack_ros.replay.lockstep import ReplayError, Results, camera_tasks, run_lockstep
from mctrack_ros.replay.quality import (
    JUMP_REMEDY,
    LEFT_OUT,
    Stamps,
    complaints,
    figures,
    pace_complaint,
)
from mctrack_ros.replay.recorded import holds_masks
from mctrack_ros.replay.results import RunFiles
from mctrack_ros.replay.stamps import corrected, judge, read_entries
from mctrack_ros.replay.workers import CameraWorkers, peak_memory_mb
from mctrack_ros.site.choice import with_tracker
from mctrack_ros.site.site import SiteConfig
from mctrack_ros.site.stated_origin import origin_text

if TYPE_CHECKING:  # a run over a bag needs no decoder of videos
    from mctrack_ros.recording.video.videos import Video


@dataclass(frozen=True, slots=True)
class Source:
    """
    A bag, and how it is read.

    Attributes
    ----------
    bag : str or Path
        With images, or recorded detections, of a site's cameras.
    namespace : str
        Where the topics of the cameras lie in it; results lie in none.
    log_times : bool
        Whether the times of recording stand for its stamps.
    first_pass : bool
        Whether backgrounds that are not given are learned from all of it beforehand; otherwise
        from its first images, as live.

    """

    bag: str | Path
    namespace: str = ''
    log_times: bool = False
    first_pass: bool = True


@dataclass(slots=True)
class TrackSummary:
    """
    What a run did.

    Attributes
    ----------
    bag_seconds : float
        How long the bag is, or the time that the videos span, s.
    ticks : int
        Ticks fused.
    images : int
        Camera messages processed.
    confirmed_ids : set of int
        Ids of tracks that were confirmed.
    peak_memory_mb : float
        Largest resident set of a process, MB.
    notes, faults : list of str
        What a user should know of the data, and why videos are not whole, a line each.
    cameras : dict of str to float
        Counts of the cameras, by name of the camera and of the count.
    left_out : Counter of (str, str)
        Ticks without a camera's mask, by camera and reason.
    tracker : str
        Which fusion tracker was used, and why.

    """

    bag_seconds: float
    ticks: int = 0
    images: int = 0
    confirmed_ids: set[int] = field(default_factory=set)
    peak_memory_mb: float = 0.0
    notes: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    cameras: dict[str, float] = field(default_factory=dict)
    left_out: Counter[tuple[str, str]] = field(default_factory=Counter)
    tracker: str = ''

    def add(self, results: Results, output: FusionOutput) -> None:
        """Count a tick."""
        self.ticks += 1
        self.images += len(results)
        tracks = output.tracks
        self.confirmed_ids.update(tracks.track_id[np.isin(tracks.status, REPORTED)].tolist())
        self.left_out.update(output.left_out.items())

    def masks_left_out(self) -> list[str]:
        """Return whose masks were left out, how often and why, a line each."""
        return [
            f'{camera}: its mask is left out of {count} of {self.ticks} ticks: {why}'
            for (camera, why), count in sorted(self.left_out.items())
        ]


@dataclass(frozen=True, slots=True)
class _Input:
    """
    A bag or videos to track.

    Attributes
    ----------
    tasks : list of CameraTask
        One for each camera.
    seconds : float
        Duration, s.
    messages : int
        Number of camera messages; of videos an estimate.
    jumps : list of Jump
        Jumps of all cameras' clocks.
    intervals : dict of str to float
        Usual time between a camera's images, s.
    starts : list of Detections
        Tracks that somebody started and ended.

    """

    tasks: list[CameraTask]
    seconds: float
    messages: int
    jumps: list[Jump]
    intervals: dict[str, float]
    starts: list[Detections] = field(default_factory=list)


def track_bag(
    source: str | Path | Source | Mapping[str, Video],
    out: str | Path,
    site: SiteConfig,
    *,
    processes: int | None = None,
    overwrite: bool = False,
    explain: bool = False,
    debug: Debug | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> TrackSummary:
    """
    Track a bag, or videos, and write ``out/bag``, ``out/tracks.txt`` and ``out/tracks.csv``.

    The same bag and site give the same bytes, whatever the number of processes; videos give
    those of the bag that `write_videos` makes of them. Text has the coordinates
    of the site's files.

    Parameters
    ----------
    source : str, Path, Source or mapping of str to Video
        Bag with images, or recorded detections, of the site's cameras; or their videos, by name.
    out : str or Path
        Folder for the results.
    site : SiteConfig
        Cameras and settings.
    processes : int, optional
        Processes for the cameras; unless given, one each: none waits for another's turn.
    overwrite : bool
        Whether earlier results there are replaced.
    explain : bool
        Whether the bag says why fusion decided as it did; all else stays the same.
    debug : Debug, optional
        Where images with what is seen in them are written, people as the site's ``blur`` says.
    progress : callable
        Called with camera messages done and in all; videos only say about how many they hold.

    Returns
    -------
    TrackSummary
        What was done.

    Raises
    ------
    ReplayError
        If recorded detections have another origin than the site, or debug images are asked for
        and the site is private.

    """
    if debug and site.private:
        raise ReplayError(f'the site {site.name} is private: no debug images are written')
    if isinstance(source, str | Path):
        source = Source(source)
    site, why = with_tracker(site, own_detections=not _suits_all(source, site))
    given = _bag(source, site) if isinstance(source, Source) else _videos(source, site)
    debug = debug and replace(debug, blur=site.blur)
    tasks = [replace(task, debug=debug) for task in given.tasks]
    summary = TrackSummary(given.seconds)
    bias: CameraBias | None = None
    with (
        RunFiles(Path(out), site, overwrite=overwrite) as files,
        closing(CameraWorkers(tasks, processes or len(tasks))) as workers,
    ):
        for results, ticked in run_lockstep(workers, site, explain=explain, starts=given.starts):
            files.write(results, ticked)
            summary.add(results, ticked.output)
            bias = ticked.bias
            progress(summary.images, given.messages)
    offsets = dict.fromkeys(site.camera_names, 0.0)
    if bias is not None:
        offsets = dict(zip(site.camera_names, np.hypot(*bias.offset.T).tolist()))
    _conclude(summary, given, workers, offsets)
    if pace := pace_complaint(given.intervals, site.fusion.batching.period):
        summary.notes.insert(0, ': '.join(pace))
    summary.tracker = why
    return summary


def _conclude(
    summary: TrackSummary, given: _Input, workers: CameraWorkers, offsets: Mapping[str, float]
) -> None:
    """Add notes and counts of the whole run; offsets: distance of cameras from the others, m."""
    summary.peak_memory_mb = max(peak_memory_mb(), workers.peak_memory_mb)
    summary.notes, summary.faults = sorted(workers.notes), sorted(workers.faults)
    summary.notes += [f'{jump}: {JUMP_REMEDY}' for jump in given.jumps]
    summary.notes += summary.masks_left_out()
    stamps = {task.camera: task.stamps or Stamps() for task in given.tasks}
    for each in sorted(workers.quality, key=lambda quality: quality.camera):
        summary.notes += complaints(each, stamps[each.camera], offsets[each.camera])
        for name, count in figures(each, stamps[each.camera]).items():
            summary.cameras[f'{each.camera}.{name}'] = count


def _suits_all(source: Source | Mapping[str, Video], site: SiteConfig) -> bool:
    """Return whether every camera has images, or what each tracker takes: masks, too."""
    if not isinstance(source, Source):
        return True
    with BagReader(source.bag, source.namespace) as reader:
        return all(
            reader.count(task.image_topic) or holds_masks(reader, task.camera)
            for task in camera_tasks(source.bag, site, source.namespace)
        )


def _check_origin(reader: BagReader, site: SiteConfig) -> None:
    """Refuse detections whose origin differs from the site's."""
    stated = stated_origin(reader)
    if stated is not None and stated != site.origin:
        raise ReplayError(
            f'the detections in {reader.path} have the origin {origin_text(stated)}, the '
            f'site has {origin_text(site.origin)}: set origin: {origin_text(stated)} in the site'
        )


def _bag(source: Source, site: SiteConfig) -> _Input:
    """Return the input of a bag, its stamps judged."""
    tasks = camera_tasks(source.bag, site, source.namespace)
    with BagReader(source.bag, source.namespace) as reader:
        topics = {topic_of(task, reader): task.camera for task in tasks}
        if any(task.fusion_topic in topics for task in tasks):
            _check_origin(reader, site)
        entries = read_entries(reader, topics, source.log_times)
        entries = corrected(entries, reader, topics, site)
        seconds = reader.duration_s
        topic = f'/{START_TOPIC}'
        asked = reader.rows(topic, Detections) if reader.count(topic) else ()
        starts = [rows for rows, _ in asked]
    stamps, jumps = judge(entries, site.camera_names, site.fusion.batching)
    unused = sum(each.stamp_ns.count(LEFT_OUT) for each in stamps.values())
    tasks = [
        replace(task, stamps=stamps[task.camera], first_pass=source.first_pass) for task in tasks
    ]
    intervals = {name: each.interval_s() for name, each in stamps.items()}
    return _Input(tasks, seconds, len(entries) - unused, jumps, intervals, starts)


def _videos(videos: Mapping[str, Video], site: SiteConfig) -> _Input:
    """Return the input of videos, from the first image of all to the last."""
    from mctrack_ros.replay.video_tasks import video_tasks

    tasks = video_tasks(videos, site)
    begin_s = min(video.begin_s for video in videos.values())
    end_s = max(video.begin_s + video.length_s for video in videos.values())
    stated = sum(video.stated for video in videos.values())
    intervals = {name: video.length_s / max(video.stated, 1) for name, video in videos.items()}
    return _Input(tasks, end_s - begin_s, stated, [], intervals)
