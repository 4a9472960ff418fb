"""A video file, a folder of images, a camera device or a stream to images."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import cv2
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.duration import Duration
from sensor_msgs.msg import CompressedImage, Image

from mctrack_ros.codec import compressed_message, image_message, jpeg_from_image
from mctrack_ros.config import ConfigError, parameter
from mctrack_ros.recording.video.live_video import LiveCounts, LiveVideo
from mctrack_ros.ros.node.diagnostics import Diagnostics
from mctrack_ros.ros.node.lifecycle import AUTOSTART, GraphNode
from mctrack_ros.ros.node.process import run
from mctrack_ros.ros.topics import quality
from mctrack_ros.ros.topics.messages import RCLPY_CLASSES
from mctrack_ros.site.names import check_camera_name, named_image_topic
from mctrack_ros.streams.credentials import user_and_password

if TYPE_CHECKING:  # a device needs no decoder of files
    from mctrack_ros.recording.video.file import VideoReading

_LONG_S = 5.0
_ARRIVAL = Duration(seconds=1)


@dataclass(frozen=True, slots=True)
class VideoNodeConfig:
    """Parameters of `video_node`."""

    autostart: bool = parameter(True, AUTOSTART)
    camera: str = parameter('cam1', 'name of the camera; its topics lie below it')
    source: str = parameter(
        '', 'video file, folder of images, device (number or path) or stream (rtsp://...)'
    )
    credentials_file: str = parameter(
        '',
        'file with user name and password of a stream, a line each; MCTRACK_VIDEO_USERNAME and '
        'MCTRACK_VIDEO_PASSWORD in the environment go before it',
    )
    rate: float = parameter(
        0.0,
        'images a second of a file or folder; 0: the times that it states [Hz]',
        minimum=0.0,
        maximum=1000.0,
    )
    realtime: bool = parameter(True, 'play a file at its times; false: as fast as possible')
    loop: bool = parameter(False, 'start a file again at its end')
    start: float = parameter(
        0.0,
        'stamp of the first image of a file, so that several play in step; 0: now '
        '[s since the epoch]',
        minimum=0.0,
    )
    image_topic: str = parameter(
        'image_raw/compressed',
        'images, below the name of the camera, or with a leading slash a whole name; one that '
        'ends in /compressed holds JPEG',
    )
    quality: int = parameter(90, 'JPEG quality [%]', minimum=1, maximum=100)
    width: int = parameter(0, 'scale images to this width; 0: keep [px]', minimum=0)
    height: int = parameter(0, 'scale images to this height; 0: keep [px]', minimum=0)
    wait: float = parameter(
        10.0, 'how long a file waits for a subscriber [s]', minimum=0.0, maximum=3600.0
    )
    reliable: bool = parameter(True, 'reliable transport: lost messages are sent again')
    depth: int = parameter(8, 'length of the queue of images', minimum=1, maximum=1000)


@dataclass(slots=True)
class SourceHealth:
    """
    State of the source: an error while a device or stream gives nothing, a warning if images drop.

    Attributes
    ----------
    sent : int
        Images published since the last report.
    live : LiveCounts, optional
        Of a device or stream.
    dropped : int
        Images dropped until the last report.

    """

    sent: int = 0
    live: LiveCounts | None = None
    dropped: int = 0

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state of the last second."""
        values, level = {'images': self.sent}, DiagnosticStatus.OK
        message = 'sending' if self.sent else 'nothing was due'
        if (live := self.live) is not None:
            dropped = live.dropped - self.dropped
            values |= {'opened': live.opened, 'dropped': live.dropped}
            if dropped:
                level, message = (
                    DiagnosticStatus.WARN,
                    f'{dropped} images dropped: sending is slow',
                )
            if not self.sent:
                level, message = DiagnosticStatus.ERROR, live.failure or 'it gives no images'
            self.dropped = live.dropped
        self.sent = 0
        return DiagnosticStatus(
            level=level,
            name=name,
            message=message,
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )


class VideoNode(GraphNode):
    """Publish images as they come, from a thread of its own; a file ends the process."""

    CONFIG = VideoNodeConfig
    config: VideoNodeConfig

    def __init__(self) -> None:
        super().__init__('video_node')
        self.live: LiveVideo | None = None

    def open(self) -> None:
        """Open the source."""
        source = self.config.source
        check_camera_name(self.config.camera)
        if not source:
            raise ConfigError('source is empty: name a video file, a device or a stream')
        self.is_file = '://' not in source and not source.isdigit() and '/dev/' not in source
        if self.is_file:
            self.open_file()
        else:
            self.address = int(source) if source.isdigit() else self.with_credentials(source)
        topic = named_image_topic(self.config.camera, self.config.image_topic)
        self.compressed = topic.endswith('/compressed')
        kind = CompressedImage if self.compressed else Image
        qos = quality.images(self.config.reliable, self.config.depth)
        self.images = self.publisher(kind, topic, qos)
        self.ending = threading.Event()
        self.health = SourceHealth()
        self.diagnostics = Diagnostics(
            self, {f'{self.config.camera} source': self.health}, (self.config.camera,)
        )

    def open_file(self) -> None:
        """
        Look into the file.

        Raises
        ------
        ConfigError
            If it is no video, or does not say when its images were taken.

        """
        from mctrack_ros.recording.video.videos import VideoError, open_video

        try:
            self.video = open_video(self.config.source, self.config.rate)
        except VideoError as error:
            raise ConfigError(f'source {error}') from error

    def with_credentials(self, source: str) -> str:
        """
        Return the address with what the file of credentials holds; nobody is shown it.

        Raises
        ------
        ConfigError
            If the source itself holds a password, or the file cannot be read.

        """
        scheme, mark, rest = source.partition('://')
        if mark and '@' in rest.partition('/')[0]:
            raise ConfigError(
                'source holds a user name or password, which others would see: put them into '
                'credentials_file, a line each, or MCTRACK_VIDEO_USERNAME and _PASSWORD'
            )
        credentials = user_and_password('VIDEO', self.config.credentials_file)
        user, password = (quote(each, safe='') for each in credentials)
        return f'{scheme}://{user}:{password}@{rest}' if mark and user else source

    def start(self) -> None:
        """Begin to play."""
        self.ending.clear()
        if not self.is_file:
            clock, warn = self.get_clock(), self.get_logger().warning
            self.live = LiveVideo(
                self.address, self.config.source, lambda: clock.now().nanoseconds, warn
            )
            self.health.live = self.live.counts
        self.diagnostics.begin()
        self.thread = threading.Thread(target=self.play, name='play')
        self.thread.start()

    def stop(self) -> None:
        """End in the middle."""
        self.ending.set()
        if self.live is not None:
            self.live.close()
        self.thread.join()

    def play(self) -> None:
        """Publish until the end, then end the process; not if the node is stopped."""
        try:
            if self.is_file:
                self.wait_for_subscriber()
                self.play_file()
                self.images.wait_for_all_acked(_ARRIVAL)
            else:
                self.play_live()
        except Exception as error:
            self.fail(str(error))
        if not self.ending.is_set():
            self.finish()

    def wait_for_subscriber(self) -> None:
        """Wait until somebody listens, so that a file's first images are not lost."""
        until = time.monotonic() + self.config.wait
        while time.monotonic() < until and not self.images.get_subscription_count():
            if self.ending.wait(0.05):
                return

    def play_file(self) -> None:
        """Publish a file's images, stamped as far apart as they were taken."""
        now_ns = self.get_clock().now().nanoseconds
        first_ns = round(self.config.start * 1e9) or now_ns
        began_ns = time.monotonic_ns() + first_ns - now_ns
        count = 0
        for since_ns, image in self.film():
            wait_s = (began_ns + since_ns - time.monotonic_ns()) * 1e-9
            if self.config.realtime and wait_s > _LONG_S:
                self.get_logger().warning(
                    f'{self.config.source}: the next image is due in {wait_s:.0f} s'
                )
            if self.ending.wait(wait_s if self.config.realtime and wait_s > 0 else 0.0):
                break
            self.send(image, first_ns + since_ns)
            count += 1
        self.get_logger().info(f'{self.config.source}: {count} images')

    def film(self) -> Iterator[tuple[int, Any]]:
        """Yield a file's images, each with its time since the first, ns; again if it loops."""
        round_ns = 0
        while True:
            reading, begin_s, since_ns = self.video.reading(), None, round_ns
            for time_s, image in reading:
                begin_s = time_s if begin_s is None else begin_s
                since_ns = round_ns + round((time_s - begin_s) * 1e9)
                yield since_ns, image
            self.tell_of(reading)
            if not (self.config.loop and reading.count):
                return
            round_ns = since_ns + round(1e9 / self.video.rate_hz)

    def tell_of(self, reading: VideoReading) -> None:
        """Log what a file that was played to its end left open, and why it is not whole."""
        for note in reading.notes():
            self.get_logger().warning(note)
        if reading.fault():
            self.get_logger().error(reading.fault())

    def play_live(self) -> None:
        """Publish what a device or stream gives: the newest image, whenever the last is sent."""
        assert self.live is not None
        for stamp_ns, image in self.live:
            self.send(image, stamp_ns)

    def send(self, image: Any, stamp_ns: int) -> None:
        """Publish one image."""
        size = (self.config.width or image.shape[1], self.config.height or image.shape[0])
        if size != (image.shape[1], image.shape[0]):
            image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        frame = f'{self.config.camera}_optical_frame'
        if self.compressed:
            jpeg = jpeg_from_image(image, self.config.quality)
            message = compressed_message(jpeg, RCLPY_CLASSES, stamp_ns, frame)
        else:
            message = image_message(image, RCLPY_CLASSES, stamp_ns, frame)
        self.images.publish(message)
        self.health.sent += 1


def main() -> int:
    """Run the node."""
    return run(VideoNode)


if __name__ == '__main__':
    sys.exit(main())
