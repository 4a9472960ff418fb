"""A video of truth and tracks from above."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation import Trajectories
from mctrack_ros.ground import GroundMapping
from mctrack_ros.report.ground_plan import pitch_lines
from mctrack_ros.report.session import Session
from mctrack_ros.simulation import LENGTH_M, WIDTH_M
from mctrack_ros.tracking.colours import track_colour

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]
Colour = tuple[int, int, int]

IMAGES_PER_SECOND = 12.5
"""Of the video at most; a recording's instants are thinned to this."""

_SCALE = 6
_MARGIN_M = 3.0
_HEADER_PX = 34
_TAIL_S = 2.0
_GRASS = np.array([52, 74, 44], np.float64)
_WHITE: Colour = (235, 235, 235)
_GREY: Colour = (170, 180, 170)
_SHIFT = 3


def write_birdseye(
    path: str | Path,
    session: Session,
    mappings: Sequence[GroundMapping] = (),
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> None:
    """
    Write a WebM video (VP8, which browsers play) in the recording's own time.

    Rings are true places, discs tracks with their ids and the last two seconds; the ground is
    the lighter the more cameras see it.

    Parameters
    ----------
    path : str or Path
        The file, ending in ``.webm``.
    session : Session
        What was tracked.
    mappings : sequence of GroundMapping
        The cameras', for what they see of the ground.
    progress : callable
        Called with images written and in all.

    Raises
    ------
    OSError
        If the video cannot be written.

    """
    background = _background(mappings)
    truth, tracks = session.trajectories()
    step = max(1, round(1e9 / session.period_ns / IMAGES_PER_SECOND))
    rate = 1e9 / session.period_ns / step
    height, width = background.shape[:2]
    fourcc = cv2.VideoWriter.fourcc(*'VP80')
    with _silent_ffmpeg():
        writer = cv2.VideoWriter(str(path), fourcc, rate, (width, height))
    if not writer.isOpened():
        raise OSError(
            f'{path} cannot be written: OpenCV has no VP8 encoder, or the folder is not there'
        )
    true_places, tails = _by_frame(truth), _Tails(tracks, session.period_ns)
    frames = range(0, len(session.truth), step)
    try:
        for index, frame in enumerate(frames):
            image = background.copy()
            here = true_places.get(frame, np.empty((0, 2)))
            shown = tails.draw(image, frame)
            for place in _pixels(here):
                cv2.circle(image, place, 8 << _SHIFT, _WHITE, 1, cv2.LINE_AA, _SHIFT)
            seconds = frame * session.period_ns * 1e-9
            _write_header(image, f'{seconds:6.1f} s   {len(here)} people   {shown} tracks')
            writer.write(image)
            progress(index + 1, len(frames))
    finally:
        writer.release()


@contextmanager
def _silent_ffmpeg() -> Iterator[None]:
    """Keep back what FFmpeg's wrapper prints although all is well: WebM has no such tag."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


class _Tails:
    """The tracks, each with the last seconds of its path."""

    def __init__(self, tracks: Trajectories, period_ns: int) -> None:
        self._length = round(_TAIL_S * 1e9 / period_ns)
        order = np.lexsort((tracks.frame, tracks.id))
        frames, ids = tracks.frame[order], tracks.id[order]
        unique, starts = np.unique(ids, return_index=True)
        self._paths = [
            (int(who), frame, _pixels(place))
            for who, frame, place in zip(
                unique,
                np.split(frames, starts[1:]),
                np.split(tracks.position[order], starts[1:]),
            )
        ]

    def draw(self, image: Image, frame: int) -> int:
        """Draw every track that is there in a frame; return how many."""
        shown = 0
        for who, frames, pixels in self._paths:
            end = int(np.searchsorted(frames, frame, 'right'))
            if not end or frames[end - 1] != frame:
                continue
            shown += 1
            red, green, blue = track_colour(who)
            colour = (blue, green, red)
            start = int(np.searchsorted(frames, frame - self._length))
            path = pixels[start:end]
            cv2.polylines(image, [path], False, colour, 1, cv2.LINE_AA, _SHIFT)
            cv2.circle(image, path[-1], 4 << _SHIFT, colour, -1, cv2.LINE_AA, _SHIFT)
            x, y = (path[-1] >> _SHIFT).tolist()
            _put_text(image, str(who), (x + 8, y - 6), 0.38, _WHITE)
        return shown


def _background(mappings: Sequence[GroundMapping]) -> Image:
    """Return the pitch, (height, width, 3), the lighter the more cameras see a place."""
    width = round((LENGTH_M + 2 * _MARGIN_M) * _SCALE)
    height = round((WIDTH_M + 2 * _MARGIN_M) * _SCALE)
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    ground = np.stack([x / _SCALE - _MARGIN_M, WIDTH_M + _MARGIN_M - y / _SCALE], axis=-1)
    seen = np.zeros(width * height)
    for mapping in mappings:
        seen += _is_seen(mapping, ground.reshape(-1, 2))
    light = 0.75 + 0.5 * seen / max(1, len(mappings))
    image = (light.reshape(height, width, 1) * _GRASS).astype(np.uint8)
    image = np.vstack([np.full((_HEADER_PX, width, 3), 24, np.uint8), image])
    lines = [_pixels(line) for line in pitch_lines()]
    cv2.polylines(image, lines, False, _GREY, 1, cv2.LINE_AA, _SHIFT)
    return image


def _is_seen(mapping: GroundMapping, ground: Floats) -> NDArray[np.bool_]:
    width, height = mapping.image_size
    pixel = mapping.image_from_ground(ground)
    with np.errstate(invalid='ignore'):
        inside = (pixel >= 0) & (pixel < (width, height))
    return np.asarray(inside.all(axis=1))


def _pixels(position: Floats) -> NDArray[np.int32]:
    """Return (n, 2) pixels of ground positions, in the fixed point of OpenCV's drawing."""
    place = np.array([_MARGIN_M, WIDTH_M + _MARGIN_M]) + position * np.array([1.0, -1.0])
    place = place * _SCALE + np.array([0, _HEADER_PX])
    return np.asarray(np.round(place * (1 << _SHIFT)), np.int32)


def _by_frame(rows: Trajectories) -> dict[int, Floats]:
    order = np.argsort(rows.frame, kind='stable')
    frames, starts = np.unique(rows.frame[order], return_index=True)
    return dict(zip(frames.tolist(), np.split(rows.position[order], starts[1:])))


def _write_header(image: Image, text: str) -> None:
    _put_text(image, text, (12, 23), 0.5, _WHITE)
    width = image.shape[1]
    _put_text(image, 'ring: true place   disc: track', (width - 215, 23), 0.4, _GREY)


def _put_text(
    image: Image, text: str, place: tuple[int, int], size: float, colour: Colour
) -> None:
    cv2.putText(image, text, place, cv2.FONT_HERSHEY_SIMPLEX, size, colour, 1, cv2.LINE_AA)
