"""One folder of images: a file each, with the times that their names state."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.recording.video.file import Video, VideoError, VideoReading

_ENDINGS = ('.bmp', '.jpeg', '.jpg', '.png', '.tif', '.tiff', '.webp')
_SECONDS = re.compile(r'\d+\.\d+')
_UNIT_S = {19: 1e-9, 16: 1e-6, 13: 1e-3, 10: 1.0}
"""Unit of a stamp by its digits: what today is in seconds since the epoch has ten."""


@dataclass(frozen=True, slots=True)
class ImageFolder(Video):
    """
    A camera's images in a folder, in the order of their times.

    Attributes
    ----------
    files : tuple of Path
        The images.
    times_s : tuple of float
        When each was taken, s; none: they are a period apart.

    """

    files: tuple[Path, ...]
    times_s: tuple[float, ...]

    @property
    def length_s(self) -> float:
        """Time from the first image until after the last, s."""
        return self.end_s - self.start_s

    def reading(self) -> VideoReading:
        """Begin to read the images."""
        return _Reading(self)


class _Reading(VideoReading):
    """Read a folder once; as `VideoReading`."""

    def __init__(self, video: ImageFolder) -> None:
        super().__init__(video)
        self._folder = video

    def __iter__(self) -> Iterator[tuple[float, NDArray[np.uint8]]]:
        """Yield the time and the image."""
        stated: tuple[float | None, ...] = self._folder.times_s or (None,) * self.video.stated
        for path, stated_s in zip(self._folder.files, stated):
            image = _image(path)
            if image is None:
                self.leave_out_undecodable(1)
                continue
            time_s = self.times.time_of(stated_s)
            if time_s is not None and self.is_of_size(image):
                yield time_s, image

    def fault(self) -> str:
        """Return why the folder is of no use; empty: it is."""
        return '' if self.count else f'{self.video.path} holds no images that can be decoded'


def open_folder(path: Path, rate_hz: float = 0.0, later_s: float = 0.0) -> ImageFolder:
    """
    Look into a folder of images.

    Without a rate, names are times: seconds with a point (``1700000000.040.jpg``), or as many
    whole seconds, milliseconds, microseconds or nanoseconds since the epoch. With one, images are
    in the order of the numbers in their names.

    Parameters
    ----------
    path : Path
        The folder.
    rate_hz : float
        Images a second, all as far apart; 0: at the times that the names state.
    later_s : float
        How long after the first video it began, s.

    Raises
    ------
    VideoError
        If it holds no images, or neither their names nor ``rate_hz`` say when they were taken.

    """
    files = [each for each in path.iterdir() if each.suffix.lower() in _ENDINGS]
    if not files:
        raise VideoError(f'{path} holds no images ({", ".join(_ENDINGS)})')
    files.sort(key=_numbers)
    times_s: list[float] = []
    if not rate_hz:
        by_time = sorted((_time_s(each), each) for each in files)
        times_s, files = [time_s for time_s, _ in by_time], [each for _, each in by_time]
        gaps_s = np.diff(times_s)
        rate_hz = 1.0 / float(np.median(gaps_s)) if gaps_s.any() else 25.0
    first = next((image for each in files if (image := _image(each)) is not None), None)
    if first is None:
        raise VideoError(f'{path} holds no images that can be decoded')
    start_s = times_s[0] if times_s else 0.0
    last_s = times_s[-1] if times_s else (len(files) - 1) / rate_hz
    return ImageFolder(
        path=path,
        rate_hz=rate_hz,
        constant=not times_s,
        stated=len(files),
        size=(first.shape[1], first.shape[0]),
        zero_s=0.0,
        end_s=last_s + 1.0 / rate_hz,
        start_s=start_s,
        later_s=later_s,
        files=tuple(files),
        times_s=tuple(times_s),
    )


def _image(path: Path) -> NDArray[np.uint8] | None:
    """Return the (height, width, 3) image, blue, green, red; None: it is none."""
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    return None if image is None else np.asarray(image, np.uint8)


def _numbers(path: Path) -> tuple[list[int], str]:
    """Return what names are ordered by: 2 comes before 10."""
    return [int(each) for each in re.findall(r'\d+', path.stem)], path.name


def _time_s(path: Path) -> float:
    """Return the time in a name, s."""
    stem = path.stem
    if _SECONDS.fullmatch(stem):
        return float(stem)
    unit_s = _UNIT_S.get(len(stem)) if stem.isdecimal() and stem.isascii() else None
    if unit_s is None:
        raise VideoError(
            f'{path} does not say when it was taken: give the rate of the images (--rate; for '
            'video_node the parameter rate), or name them by their times'
        )
    return int(stem) * unit_s
