"""Videos and folders of images as the messages of a bag, to be tracked offline."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.recording.bags.writer import ROSBAGS_CLASSES, BagWriter
from mctrack_ros.recording.video.file import Video, VideoError, VideoReading, open_file
from mctrack_ros.recording.video.folder import open_folder

__all__ = [
    'START_NS',
    'CameraVideo',
    'Video',
    'VideoError',
    'open_video',
    'strangers',
    'together',
    'write_videos',
]

START_NS = 1_700_000_000_000_000_000
"""When the first video is said to have begun: the same videos give the same bag."""


@dataclass(frozen=True, slots=True)
class CameraVideo:
    """
    A camera's video among several on one time line.

    Attributes
    ----------
    camera : str
        Name of the camera.
    video : Video
        Its file.
    origin_ns : int
        Stamp of the time line's zero, ns.

    """

    camera: str
    video: Video
    origin_ns: int

    def reading(self) -> VideoReading:
        """Begin to read the file."""
        return self.video.reading()

    def messages(self, reading: VideoReading) -> Iterator[tuple[str, Any, int]]:
        """Yield topic, compressed image and stamp (ns) of all that a reading gives."""
        topic, frame = f'/{self.camera}/image_raw/compressed', f'{self.camera}_optical_frame'
        for time_s, image in reading:
            stamp_ns = self.origin_ns + round((self.video.later_s + time_s) * 1e9)
            jpeg = jpeg_from_image(image)
            yield topic, compressed_message(jpeg, ROSBAGS_CLASSES, stamp_ns, frame), stamp_ns


def open_video(path: str | Path, rate_hz: float = 0.0, later_s: float = 0.0) -> Video:
    """
    Look into a video file, or a folder of images.

    Parameters
    ----------
    path : str or Path
        The file or folder.
    rate_hz : float
        Images a second, all as far apart; 0: at the times that the file, or their names, state.
    later_s : float
        How long after the first video it began, s.

    Raises
    ------
    VideoError
        If it is none, or neither it nor ``rate_hz`` says when its images were taken.

    """
    path = Path(path)
    if not path.exists():
        raise VideoError(f'{path} does not exist')
    return (open_folder if path.is_dir() else open_file)(path, rate_hz, later_s)


def together(videos: Mapping[str, Video]) -> dict[str, CameraVideo]:
    """
    Put the videos of several cameras on one time line.

    The first image of the first lies half a period of the fastest after `START_NS`: times that
    a file states in whole milliseconds so stay on the same side of a tick's edge.
    """
    lead_s = 0.5 / max(video.rate_hz for video in videos.values())
    first_s = min(video.begin_s for video in videos.values())
    origin_ns = START_NS + round((lead_s - first_s) * 1e9)
    return {name: CameraVideo(name, video, origin_ns) for name, video in videos.items()}


def strangers(videos: Mapping[str, Video]) -> list[str]:
    """Return a line for each video that begins after another, by what they state, has ended."""
    spans = {
        name: (video.begin_s, video.begin_s + video.length_s)
        for name, video in videos.items()
        if video.length_s
    }
    return [
        f'{later} begins at {begin_s:.2f} s, after the end of {name} at {end_s:.2f} s: they show '
        'no common time (--later sets it)'
        for name, (_, end_s) in spans.items()
        for later, (begin_s, _) in spans.items()
        if begin_s >= end_s
    ]


def write_videos(
    videos: Mapping[str, Video],
    out: str | Path,
    *,
    overwrite: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
    tell: Callable[[str], None] = lambda line: None,
) -> dict[str, int]:
    """
    Write the images of videos into a bag, on ``/<camera>/image_raw/compressed``.

    Parameters
    ----------
    videos : mapping of str to Video
        By the name of the camera.
    out : str or Path
        The bag.
    overwrite : bool
        Whether a bag already there is replaced.
    progress : callable
        Called with images done and, by what the files state, in all.
    tell : callable
        Called with a line for everything that was left out or made up.

    Returns
    -------
    dict of str to int
        How many images of each camera.

    Raises
    ------
    VideoError
        If a video holds no images or breaks off; the bag holds what was read.
    BagError
        If the bag cannot be written.

    """
    sources = together(videos)
    readings = {name: source.reading() for name, source in sources.items()}
    total = sum(video.stated for video in videos.values())
    streams = [source.messages(readings[name]) for name, source in sources.items()]
    with BagWriter(out, overwrite=overwrite) as bag:
        for topic, message, stamp_ns in heapq.merge(*streams, key=lambda item: item[::-2]):
            bag.write(topic, message, stamp_ns)
            progress(sum(reading.count for reading in readings.values()), total)
    for line in (note for reading in readings.values() for note in reading.notes()):
        tell(line)
    faults = [fault for reading in readings.values() if (fault := reading.fault())]
    if faults:
        raise VideoError(f'{"; ".join(faults)}; {out} holds what was read')
    return {name: reading.count for name, reading in readings.items()}
