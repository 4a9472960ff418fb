"""Track a bag or videos offline: tracks, events and feedback as a bag, and as text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mctrack_ros.interfaces import REPORTED
from mctrack_ros.recording import (
    BagReader,
    BagWriter,
    MotTextWriter,
    TrackTableWriter,
    stated_origin,
)
from mctrack_ros.replay.camera_source import CameraTask, topic_of
from mctrack_ros.replay.lockstep import ReplayError, TickOutput, camera_tasks, run_lockstep
from mctrack_ros.replay.workers import CameraWorkers, peak_memory_mb
from mctrack_ros.site_config import SiteConfig
from mctrack_ros.stated_origin import origin_text

if TYPE_CHECKING:  # a run over a bag needs no decoder of videos
    from mctrack_ros.recording.videos import Video

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
    pictures : int
        Camera messages processed.
    confirmed_ids : set of int
        Ids of tracks that were confirmed.
    peak_memory_mb : float
        Largest resident set of a process, MB.
    notes, faults : list of str
        What the videos left open, and why they are not whole, a line each.

    """

    bag_seconds: float
    ticks: int = 0
    pictures: int = 0
    confirmed_ids: set[int] = field(default_factory=set)
    peak_memory_mb: float = 0.0
    notes: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)


def track_bag(
    bag: str | Path | Mapping[str, Video],
    out: str | Path,
    site: SiteConfig,
    *,
    namespace: str = '',
    processes: int | None = None,
    overwrite: bool = False,
    explain: bool = False,
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
        With pictures, or recorded detections, of the site's cameras; or their videos, by name.
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
        tasks, seconds, total = _videos(bag, site)
    else:
        tasks, seconds, total = _bag(bag, site, namespace)
    summary = TrackSummary(seconds)
    out = Path(out)
    with (
        BagWriter(out / 'bag', overwrite=overwrite) as writer,
        MotTextWriter(out / 'tracks.txt', tasks[0].period_ns, origin=site.origin) as text,
        TrackTableWriter(out / 'tracks.csv', tasks[0].period_ns, site.origin) as table,
        closing(CameraWorkers(tasks, processes or len(tasks))) as workers,
    ):
        for ticked in run_lockstep(workers, site, explain=explain):
            if summary.ticks == 0:
                writer.write_text('/site', site.description(), ticked.tick.stamp_ns)
            _write(writer, ticked, site.ground_frame)
            text.write(ticked.output.tracks)
            table.write(ticked.output.tracks)
            summary.ticks += 1
            summary.pictures += len(ticked.results)
            tracks = ticked.output.tracks
            confirmed = tracks.track_id[np.isin(tracks.status, REPORTED)]
            summary.confirmed_ids.update(confirmed.tolist())
            progress(summary.pictures, total)
    summary.peak_memory_mb = max(peak_memory_mb(), workers.peak_memory_mb)
    summary.notes, summary.faults = sorted(workers.notes), sorted(workers.faults)
    return summary


def _check_origin(reader: BagReader, site: SiteConfig) -> None:
    """Refuse detections that are told from elsewhere than the site's positions."""
    told = stated_origin(reader)
    if told is not None and told != site.origin:
        raise ReplayError(
            f'the detections in {reader.path} are told from the origin {origin_text(told)}, the '
            f'site has {origin_text(site.origin)}: set origin: {origin_text(told)} in the site'
        )


def _bag(bag: str | Path, site: SiteConfig, namespace: str) -> tuple[list[CameraTask], float, int]:
    """Return the tasks over a bag, its length, s, and how many messages they take."""
    tasks = camera_tasks(bag, site, namespace)
    with BagReader(bag, namespace) as reader:
        topics = [topic_of(task, reader) for task in tasks]
        if any(topic == task.detections_topic for topic, task in zip(topics, tasks)):
            _check_origin(reader, site)
        return tasks, reader.duration_s, sum(reader.count(topic) for topic in topics)


def _videos(videos: Mapping[str, Video], site: SiteConfig) -> tuple[list[CameraTask], float, int]:
    """Return the tasks over videos, the time they span, s, and about how many pictures."""
    from mctrack_ros.replay.video_tasks import video_tasks

    tasks = video_tasks(videos, site)
    begin_s = min(video.begin_s for video in videos.values())
    end_s = max(video.begin_s + video.length_s for video in videos.values())
    return tasks, end_s - begin_s, sum(video.stated for video in videos.values())


def _write(writer: BagWriter, ticked: TickOutput, frame_id: str) -> None:
    """
    Append everything of one tick, in a fixed order, logged at the tick's stamp.

    As from the nodes there is no message where nothing happened.
    """
    now_ns = ticked.tick.stamp_ns
    for result in ticked.results:
        if len(result.events):
            writer.write_rows(f'/{result.camera}/events', result.events, frame_id, now_ns)
        writer.write_rows(f'/{result.camera}/detections', result.detections, frame_id, now_ns)
    writer.write_rows('/ticks', ticked.tick.record, frame_id, now_ns)
    writer.write_rows('/tracks', ticked.output.tracks, frame_id, now_ns)
    if len(ticked.output.events):
        writer.write_rows('/events', ticked.output.events, frame_id, now_ns)
    writer.write_rows('/feedback', ticked.feedback, frame_id, now_ns)
    if ticked.explanation is not None:
        writer.write_rows(CANDIDATES_TOPIC, ticked.explanation.candidates, frame_id, now_ns)
        writer.write_rows(DECISIONS_TOPIC, ticked.explanation.decisions, frame_id, now_ns)
