"""Video files as a bag of pictures, to be tracked offline."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.recording.bag import ROSBAGS_CLASSES, BagWriter

START_NS = 1_700_000_000_000_000_000
"""When the first video is said to have begun: the same videos give the same bag."""
_RATES_HZ = (1.0, 1000.0)
_MISSING_SHARE = 0.02
"""Share of the pictures that a file states and need not hold: the count is an estimate."""


class VideoError(ValueError):
    """A video that cannot be read; names it and says why."""


@dataclass(frozen=True, slots=True)
class Video:
    """
    A camera's video.

    Attributes
    ----------
    path : Path
        The file.
    rate_hz : float
        Pictures a second.
    stated : int
        How many pictures the file says that it holds; 0: it does not.
    size : (int, int)
        Width and height of the pictures, px.
    later_s : float
        How long after the first video it began, s.

    """

    path: Path
    rate_hz: float
    stated: int
    size: tuple[int, int]
    later_s: float = 0.0

    def stamp_ns(self, index: int) -> int:
        """Return the stamp of a picture: the middle of its period."""
        return START_NS + round((self.later_s + (index + 0.5) / self.rate_hz) * 1e9)

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """Yield the (height, width, 3) pictures, blue, green, red."""
        capture = cv2.VideoCapture(str(self.path))
        try:
            while True:
                found, picture = capture.read()
                if not found:
                    return
                yield np.asarray(picture, np.uint8)
        finally:
            capture.release()


def open_video(path: str | Path, rate_hz: float = 0.0, later_s: float = 0.0) -> Video:
    """
    Look into a video file.

    Parameters
    ----------
    path : str or Path
        The file.
    rate_hz : float
        Pictures a second; 0: what the file states.
    later_s : float
        How long after the first video it began, s.

    Raises
    ------
    VideoError
        If it is none, or states no rate.

    """
    path = Path(path)
    if not path.is_file():
        raise VideoError(f'{path} does not exist')
    capture = cv2.VideoCapture(str(path))
    try:
        if not capture.isOpened():
            raise VideoError(f'{path} is no video that OpenCV reads')
        stated = capture.get(cv2.CAP_PROP_FPS)
        count = max(int(capture.get(cv2.CAP_PROP_FRAME_COUNT)), 0)
        width, height = (
            int(capture.get(key)) for key in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT)
        )
    finally:
        capture.release()
    low, high = _RATES_HZ
    if not (rate_hz or low <= stated <= high):
        raise VideoError(f'{path} does not say how many pictures a second it holds: give --rate')
    return Video(path, rate_hz or stated, count, (width, height), later_s)


def write_videos(
    videos: Mapping[str, Video],
    out: str | Path,
    *,
    overwrite: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> dict[str, int]:
    """
    Write the pictures of videos into a bag, on ``/<camera>/image_raw/compressed``.

    Parameters
    ----------
    videos : mapping of str to Video
        By the name of the camera.
    out : str or Path
        The bag.
    overwrite : bool
        Whether a bag already there is replaced.
    progress : callable
        Called with pictures done and, by what the files state, in all.

    Returns
    -------
    dict of str to int
        How many pictures of each camera.

    Raises
    ------
    VideoError
        If a video holds no pictures, or ends far before its stated end.
    BagError
        If the bag cannot be written.

    """
    counts, total = dict.fromkeys(videos, 0), sum(video.stated for video in videos.values())
    streams = [_stamped(name, video) for name, video in videos.items()]
    with BagWriter(out, overwrite=overwrite) as bag:
        for stamp_ns, name, jpeg in heapq.merge(*streams, key=lambda item: item[:2]):
            frame = f'{name}_optical_frame'
            message = compressed_message(jpeg, ROSBAGS_CLASSES, stamp_ns, frame)
            bag.write(f'/{name}/image_raw/compressed', message, stamp_ns)
            counts[name] += 1
            progress(sum(counts.values()), total)
    for name, video in videos.items():
        if counts[name] < max(1, (1 - _MISSING_SHARE) * video.stated):
            raise VideoError(f'{video.path} breaks off after {counts[name]} of {video.stated}')
    return counts


def _stamped(name: str, video: Video) -> Iterator[tuple[int, str, NDArray[np.uint8]]]:
    """Yield stamp, camera and JPEG of each picture."""
    for index, picture in enumerate(video.pictures()):
        yield video.stamp_ns(index), name, jpeg_from_image(picture)
