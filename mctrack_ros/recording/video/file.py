"""One video file: its images and the times that it states for them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from pathlib import Path
from typing import cast

import av
import numpy as np
from av.container import InputContainer
from av.format import Flags
from av.video.frame import VideoFrame
from av.video.reformatter import VideoReformatter
from av.video.stream import VideoStream
from numpy.typing import NDArray

from mctrack_ros.recording.video.image_times import ImageTimes

_RATES_HZ = (1.0, 240.0)
_USUAL_RATE_HZ = 25.0
_MISSING_SHARE, _MISSING_S = 0.02, 1.0
"""By how much a file may end before the end that it states: the statement is an estimate."""


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
        Usual images a second.
    constant : bool
        Whether images are taken as that far apart, whatever times the file states.
    stated : int
        About how many images the file says that it holds; 0: it does not.
    size : (int, int)
        Width and height of the images, upright, px.
    zero_s, end_s : float
        Where the file's time line begins and is said to end, in its own stamps, s; an end of 0:
        it is not said.
    start_s : float
        When the first image was taken on that time line, s.
    later_s : float
        How long after the first video this one began, s.

    """

    path: Path
    rate_hz: float
    constant: bool
    stated: int
    size: tuple[int, int]
    zero_s: float
    end_s: float
    start_s: float
    later_s: float

    @property
    def begin_s(self) -> float:
        """When the first image was taken, on the time line of all videos, s."""
        return self.later_s + self.start_s

    @property
    def length_s(self) -> float:
        """How long the file says that it is, s; 0: it does not."""
        return max(self.end_s - self.zero_s, 0.0)

    def reading(self) -> VideoReading:
        """Begin to read the file."""
        return VideoReading(self)

    def images(self) -> Iterator[NDArray[np.uint8]]:
        """Yield the (height, width, 3) images, blue, green, red."""
        for _, image in self.reading():
            yield image


class VideoReading:
    """
    Read a video once, from its first image to its last; yields time and image.

    The time (s) is that of the file's own time line; images are (height, width, 3), blue,
    green, red, turned upright as the file asks. What cannot be decoded is left out.

    Parameters
    ----------
    video : Video
        As `open_file` gives it.

    Attributes
    ----------
    count : int
        Images so far.

    """

    def __init__(self, video: Video) -> None:
        self.video, self.count = video, 0
        self.times = ImageTimes(1.0 / video.rate_hz, constant=video.constant)
        self._undecodable, self._resized, self._end_s, self._failure = 0, 0, 0.0, ''
        self._due_s: list[float] | None = None

    def __iter__(self) -> Iterator[tuple[float, NDArray[np.uint8]]]:
        """Yield the time and the image."""
        convert = VideoReformatter()
        with _opened(self.video.path) as container:
            self._due_s = [] if _tells_decoding_only(container) else None
            for frame in self._frames(container):
                own_s = frame.time if self._due_s is None else heappop(self._due_s)
                stated_s = None if own_s is None else own_s - self.video.zero_s
                time_s = self.times.time_of(stated_s)
                if time_s is None:
                    continue
                image = _image(frame, convert)
                if self.is_of_size(image):
                    yield time_s, image

    def is_of_size(self, image: NDArray[np.uint8]) -> bool:
        """Count an image; return whether it has the size of the video."""
        is_it = image.shape[1::-1] == self.video.size
        self.count += is_it
        self._resized += not is_it
        return is_it

    def leave_out_undecodable(self, count: int) -> None:
        """Count images that cannot be decoded."""
        self._undecodable += count
        self.times.pass_over(count)

    def notes(self) -> list[str]:
        """Return what was left out or made up so far, a line each."""
        lines = self.times.notes()
        if self._resized:
            lines.insert(0, f'images left out that have another size: {self._resized}')
        if self._undecodable:
            lines.insert(0, f'images left out that cannot be decoded: {self._undecodable}')
        return [f'{self.video.path}: {line}' for line in lines]

    def fault(self) -> str:
        """Return why a file that was read to its end is not whole; empty: it is."""
        path = self.video.path
        if not self.count:
            return f'{path} holds no images that can be decoded'
        reason = self._failure or self._early_end()
        if not reason:
            return ''
        at_s = self._end_s - self.video.zero_s
        return f'{path} breaks off after {self.count} images, at {at_s:.2f} s: {reason}'

    def _frames(self, container: InputContainer) -> Iterator[VideoFrame]:
        """Yield what can be decoded; note what cannot, and where the packets end."""
        stream = _stream(container)
        packets = container.demux()
        while True:
            try:
                packet = next(packets, None)
            except av.FFmpegError as error:
                self._failure = str(error.strerror)
                return
            if packet is None:
                return
            if packet.pts is not None:
                end = (packet.pts + (packet.duration or 0)) * packet.time_base
                self._end_s = max(self._end_s, float(end))
            if packet.stream_index == stream.index:
                yield from self._decoded(stream, cast('av.Packet[VideoStream]', packet))

    def _decoded(self, stream: VideoStream, packet: av.Packet[VideoStream]) -> list[VideoFrame]:
        """Return the sound images of a packet; count the others."""
        if self._due_s is not None and packet.size and packet.dts is not None:
            heappush(self._due_s, float(packet.dts * packet.time_base))
        try:
            frames = stream.decode(packet)
        except av.FFmpegError:
            self._pass_over(1)
            return []
        sound = [frame for frame in frames if not frame.is_corrupt]
        self._pass_over(len(frames) - len(sound))
        return sound

    def _pass_over(self, count: int) -> None:
        for _ in range(count):
            if self._due_s:
                heappop(self._due_s)
        self.leave_out_undecodable(count)

    def _early_end(self) -> str:
        """Return why the file should go on where its packets end; empty: it need not."""
        video = self.video
        stated = _riff_size(video.path)
        if stated:
            size = video.path.stat().st_size
            return f'{size} of {stated} bytes are there' if size < stated else ''
        slack_s = max(2 / video.rate_hz, min(_MISSING_S, _MISSING_SHARE * video.length_s))
        if self._end_s < video.end_s - slack_s:
            return f'the file says that it is {video.length_s:.2f} s long'
        return ''


def open_file(path: Path, rate_hz: float = 0.0, later_s: float = 0.0) -> Video:
    """
    Look into a video file.

    Parameters
    ----------
    path : Path
        The file.
    rate_hz : float
        Images a second, all as far apart; 0: at the times that the file states.
    later_s : float
        How long after the first video it began, s.

    Raises
    ------
    VideoError
        If it is none, or neither it nor ``rate_hz`` says when its images were taken.

    """
    with _opened(path) as container:
        stream, flags = _stream(container), Flags(container.format.flags)
        if not rate_hz and Flags.no_timestamps in flags:
            raise VideoError(
                f'{path} does not say when its images were taken: give their rate (--rate; for '
                'video_node the parameter rate)'
            )
        usual_hz = rate_hz or _usual_rate_hz(stream)
        first, delay_s = _first_frame(container, path)
        is_timed = not (rate_hz or first.time is None or _tells_decoding_only(container))
        begin_s = (container.start_time or 0) / av.time_base
        anywhere = Flags.ts_discont in flags
        zero_s = begin_s if anywhere else delay_s if is_timed else 0.0
        length_s = (container.duration or 0) / av.time_base
        upright = (first.width, first.height)
        return Video(
            path=path,
            rate_hz=usual_hz,
            constant=bool(rate_hz),
            stated=_stated(stream.frames, round(length_s * usual_hz)),
            size=upright[::-1] if first.rotation % 180 else upright,
            zero_s=zero_s,
            end_s=length_s + (begin_s if anywhere else 0.0) if length_s else 0.0,
            start_s=first.time - zero_s if is_timed else 0.0,
            later_s=later_s,
        )


def _opened(path: Path) -> InputContainer:
    """
    Open a file.

    Raises
    ------
    VideoError
        If it holds no video.

    """
    try:
        container = av.open(str(path))
    except av.FFmpegError as error:
        raise VideoError(
            f'{path} is no video that can be read: {error.strerror} (was its recording cut off? '
            'Some kinds have their index at the end)'
        ) from error
    if not container.streams.video:
        container.close()
        raise VideoError(f'{path} is no video: it holds no images')
    return container


def _tells_decoding_only(container: InputContainer) -> bool:
    """
    Tell whether a file says when images are decoded, and not when they are shown.

    Its images come out of the decoder in the order in which they are shown: each takes the
    earliest of the times that are left.
    """
    return container.format.name == 'avi'


def _stream(container: InputContainer) -> VideoStream:
    """Return the stream of images; a cover is none."""
    stream = container.streams.best('video')
    assert isinstance(stream, VideoStream)
    return stream


def _first_frame(container: InputContainer, path: Path) -> tuple[VideoFrame, float]:
    """
    Return the first image that can be decoded, and the delay of reordered ones, s.

    Some containers count from where decoding begins: a first image that then waits for its turn
    is no later for that.
    """
    stream = _stream(container)
    packets, delay_s = container.demux(stream), None
    while True:
        try:
            packet = next(packets, None)
            if packet is None:
                raise VideoError(f'{path} holds no images that can be decoded')
            if delay_s is None:
                waits = packet.dts == 0 and packet.pts is not None
                delay_s = float((packet.pts or 0) * packet.time_base) if waits else 0.0
            for frame in stream.decode(packet):
                return frame, delay_s
        except av.FFmpegError:
            continue


def _usual_rate_hz(stream: VideoStream) -> float:
    """Return how many images a second are usual, from what the file says."""
    low, high = _RATES_HZ
    for rate in (stream.guessed_rate, stream.average_rate):
        if rate and low <= rate <= high:
            return float(rate)
    return _USUAL_RATE_HZ


def _stated(by_count: int, by_length: int) -> int:
    """Return about how many images a file says that it holds, of two statements."""
    return min(by_count, by_length) if by_count and by_length else by_count or by_length


def _image(frame: VideoFrame, convert: VideoReformatter) -> NDArray[np.uint8]:
    """Return the image, blue, green, red, upright."""
    image = convert.reformat(frame, format='bgr24').to_ndarray()
    return np.ascontiguousarray(np.rot90(image, frame.rotation // 90), np.uint8)


def _riff_size(path: Path) -> int:
    """Return the size that the header of an AVI file states; 0: it is none, or states none."""
    with path.open('rb') as file:
        head = file.read(8)
    stated = int.from_bytes(head[4:], 'little')
    return stated + 8 if head[:4] == b'RIFF' and stated else 0
