"""Track a bag or videos offline: tracks, events and feedback as a bag, and as text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mctrack_ros.fusion import open_fusion
from mctrack_ros.fusion.camera_clocks import Jump
from mctrack_ros.interfaces import REPORTED
from mctrack_ros.recording import (
    BagReader,
    BagWriter,
    MotTextWriter,
    TrackTableWriter,
    stated_origin,
)
from mctrack_ros.replay.camera_source import CameraTask, Debug, topic_of
from mctrack_ros.replay.lockstep import ReplayError, TickOutput, camera_tasks, run_lockstep
from mctrack_ros.replay.quality import JUMP_REMEDY, LEFT_OUT, Stamps, complaints, figures
from mctrack_ros.replay.stamps import judge, read_entries
from mctrack_ros.replay.workers import CameraWorkers, peak_memory_mb
from mctrack_ros.site.site import SiteConfig
from mctrack_ros.site.stated_origin import origin_text

if TYPE_CHECKING:  # a run over a bag needs no decoder of videos
    from mctrack_ros.recording.video.videos import Video

CANDIDATES_TOPIC = '/explanation/candidates'
DECISIONS_TOPIC = '/explanation/decisions'


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

    """

    bag_seconds: float
    ticks: int = 0
    images: int = 0
    confirmed_ids: set[int] = field(default_factory=set)
    peak_memory_mb: float = 0.0
    notes: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    cameras: dict[str, float] = field(default_factory=dict)


def track_bag(
    bag: str | Path | Mapping[str, Video],
    out: str | Path,
    site: SiteConfig,
    *,
    namespace: str = '',
    processes: int | None = None,
    overwrite: bool = False,
    explain: bool = False,
    log_times: bool = False,
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
    bag : str, Path or mapping of str to Video
        With images, or recorded detections, of the site's cameras; or their videos, by name.
    out : str or Path
        Folder for the results.
    site : SiteConfig
        Cameras and settings.
    namespace : str
        Where the topics of the cameras lie in the bag; the results lie in none.
    processes : int, optional
        Processes for the cameras; unless given, one each: none waits for another's turn.
    overwrite : bool
        Whether earlier results there are replaced.
    explain : bool
        Whether the bag says why fusion decided as it did; all else stays the same.
    log_times : bool
        Whether the times of recording stand for the stamps of a bag.
    debug : Debug, optional
        Where images with what is seen in them are written.
    progress : callable
        Called with camera messages done and in all; videos only say about how many they hold.

    Returns
    -------
    TrackSummary
        What was done.

    Raises
    ------
    ReplayError
        If recorded detections are told from another origin than the site's.

    """
    if isinstance(bag, Mapping):
        (tasks, seconds, total), jumps = _videos(bag, site), list[Jump]()
    else:
        tasks, seconds, total, jumps = _bag(bag, site, namespace, log_times)
    tasks = [replace(task, debug=debug) for task in tasks]
    log = _LogTimes(tasks[0].period_ns)
    summary, fusion = TrackSummary(seconds), open_fusion(site.fusion, site.camera_names)
    out = Path(out)
    with (
        BagWriter(out / 'bag', overwrite=overwrite) as writer,
        MotTextWriter(out / 'tracks.txt', tasks[0].period_ns, origin=site.origin) as text,
        TrackTableWriter(out / 'tracks.csv', tasks[0].period_ns, site.origin) as table,
        closing(CameraWorkers(tasks, processes or len(tasks))) as workers,
    ):
        for ticked in run_lockstep(workers, site, fusion=fusion, explain=explain):
            if summary.ticks == 0:
                began_ns = ticked.tick.stamp_ns
                writer.write_text('/site', site.description(began_ns), began_ns)
            _write(writer, ticked, site.ground_frame, log.time_ns(ticked))
            text.write(ticked.output.tracks)
            table.write(ticked.output.tracks)
            summary.ticks += 1
            summary.images += len(ticked.results)
            tracks = ticked.output.tracks
            confirmed = tracks.track_id[np.isin(tracks.status, REPORTED)]
            summary.confirmed_ids.update(confirmed.tolist())
            progress(summary.images, total)
    summary.peak_memory_mb = max(peak_memory_mb(), workers.peak_memory_mb)
    summary.notes, summary.faults = sorted(workers.notes), sorted(workers.faults)
    summary.notes += [f'{jump}: {JUMP_REMEDY}' for jump in jumps]
    offsets = dict.fromkeys(site.camera_names, 0.0)
    if fusion.bias is not None:
        offsets = dict(zip(site.camera_names, np.hypot(*fusion.bias.offset.T).tolist()))
    stamps = {task.camera: task.stamps or Stamps() for task in tasks}
    for each in sorted(workers.quality, key=lambda quality: quality.camera):
        summary.notes += complaints(each, stamps[each.camera], offsets[each.camera])
        for name, count in figures(each, stamps[each.camera]).items():
            summary.cameras[f'{each.camera}.{name}'] = count
    return summary


def _check_origin(reader: BagReader, site: SiteConfig) -> None:
    """Refuse detections whose origin differs from the site's."""
    told = stated_origin(reader)
    if told is not None and told != site.origin:
        raise ReplayError(
            f'the detections in {reader.path} are told from the origin {origin_text(told)}, the '
            f'site has {origin_text(site.origin)}: set origin: {origin_text(told)} in the site'
        )


def _bag(
    bag: str | Path, site: SiteConfig, namespace: str, log_times: bool
) -> tuple[list[CameraTask], float, int, list[Jump]]:
    """Return tasks over a bag, its length, s, their number of messages, and clocks' jumps."""
    tasks = camera_tasks(bag, site, namespace)
    with BagReader(bag, namespace) as reader:
        topics = {topic_of(task, reader): task.camera for task in tasks}
        if any(task.told_topic in topics for task in tasks):
            _check_origin(reader, site)
        entries = read_entries(reader, topics, log_times)
        seconds = reader.duration_s
    stamps, jumps = judge(entries, site.camera_names, site.fusion.batching)
    unused = sum(each.stamp_ns.count(LEFT_OUT) for each in stamps.values())
    tasks = [replace(task, stamps=stamps[task.camera]) for task in tasks]
    return tasks, seconds, len(entries) - unused, jumps


def _videos(videos: Mapping[str, Video], site: SiteConfig) -> tuple[list[CameraTask], float, int]:
    """Return the tasks over videos, the time they span, s, and about how many images."""
    from mctrack_ros.replay.video_tasks import video_tasks

    tasks = video_tasks(videos, site)
    begin_s = min(video.begin_s for video in videos.values())
    end_s = max(video.begin_s + video.length_s for video in videos.values())
    return tasks, end_s - begin_s, sum(video.stated for video in videos.values())


class _LogTimes:
    """Log times of ticks: their stamps, continued where time begins anew."""

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._last_ns = self._added_ns = self._session = 0

    def time_ns(self, ticked: TickOutput) -> int:
        """Return the log time of a tick, ns."""
        stamp_ns, session = ticked.tick.stamp_ns, ticked.results[0].session
        if session > self._session:
            self._session = session
            self._added_ns = self._last_ns + self._period_ns - stamp_ns
        self._last_ns = stamp_ns + self._added_ns
        return self._last_ns


def _write(writer: BagWriter, ticked: TickOutput, frame_id: str, now_ns: int) -> None:
    """
    Append everything of one tick, in a fixed order, logged at a time, ns.

    As from the nodes there is no message where nothing happened.
    """
    for result in ticked.results:
        if len(result.events):
            writer.write_rows(f'/{result.camera}/events', result.events, frame_id, now_ns)
        for topic, rows in result.messages.items():
            writer.write_rows(f'/{result.camera}/{topic}', rows, frame_id, now_ns)
    writer.write_rows('/ticks', ticked.tick.record, frame_id, now_ns)
    writer.write_rows('/tracks', ticked.output.tracks, frame_id, now_ns)
    if len(ticked.output.events):
        writer.write_rows('/events', ticked.output.events, frame_id, now_ns)
    writer.write_rows('/feedback', ticked.feedback, frame_id, now_ns)
    if ticked.explanation is not None:
        writer.write_rows(CANDIDATES_TOPIC, ticked.explanation.candidates, frame_id, now_ns)
        writer.write_rows(DECISIONS_TOPIC, ticked.explanation.decisions, frame_id, now_ns)
