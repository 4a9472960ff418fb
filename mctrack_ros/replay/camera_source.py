"""The output of one camera at each stamp: from images of a bag or video, or as recorded."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import (
    image_from_message,
    jpeg_from_image,
    message_from_ros,
    stamp_ns_of,
)
from mctrack_ros.interfaces import Detections, Events, Message, Rows
from mctrack_ros.interfaces.rows import MOST_WAITING
from mctrack_ros.perception import (
    ImageState,
    ImageWatch,
    RowsBuffer,
    ShiftState,
    camera_method,
    open_buffer,
)
from mctrack_ros.perception.background.plate import spread_median
from mctrack_ros.perception.image_state import is_blank
from mctrack_ros.perception.mosaic import without_faces
from mctrack_ros.perception.output import CameraOutput
from mctrack_ros.perception.overlay import Overlay
from mctrack_ros.recording import BagError, BagReader
from mctrack_ros.replay.quality import LEFT_OUT, SECOND_NS, CameraQuality, Stamps
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.names import is_name, named_image_topic, resolved

if TYPE_CHECKING:  # a run over a bag needs no decoder of videos
    from mctrack_ros.recording.video.file import VideoReading
    from mctrack_ros.recording.video.videos import CameraVideo, Video

Image = NDArray[np.uint8]
_IMAGES = ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage')

SPREAD_IMAGES = 49
"""From so many images a background is made: people cover a place in less than half of them."""
LEAST_IMAGES = 9

SESSION = 1 << 44
"""Ticks of session n are numbered from n times this."""


@dataclass(frozen=True, slots=True)
class Debug:
    """
    Images with boxes, ids, groups and predictions, as files.

    Attributes
    ----------
    folder : Path
        Where they go, in a folder for each camera.
    every_s : float
        Time between them, s.
    blur : bool
        Whether people in them are made unrecognisable.

    """

    folder: Path
    every_s: float
    blur: bool = True


@dataclass(frozen=True, slots=True)
class CameraTask:
    """
    One camera of a bag, or a video of its own.

    Attributes
    ----------
    bag : Path
        The bag, or the file of the video.
    camera : str
        Name of the camera.
    settings : CameraSettings
        Its topics, calibration and pipeline.
    period_ns, delay_ns : int
        Tick period and feedback delay, ns.
    namespace : str
        Where its topics lie in the bag.
    video : CameraVideo, optional
        The video; its images are compressed as `import-videos` does, so they track alike.
    stamps : Stamps, optional
        How the stamps of its messages are used; unless given, as they are.
    debug : Debug, optional
        Where images with what is seen in them are written.
    kinds : tuple of type
        Messages to fusion, where these are replayed instead of images.
    first_pass : bool
        Whether a background that is not given is learned from the whole recording beforehand;
        otherwise as in a live node, from the first images.

    """

    bag: Path
    camera: str
    settings: CameraSettings
    period_ns: int
    delay_ns: int
    namespace: str = ''
    video: CameraVideo | None = None
    stamps: Stamps | None = None
    debug: Debug | None = None
    kinds: tuple[type[Message], ...] = (Detections,)
    first_pass: bool = True

    @property
    def image_topic(self) -> str:
        """Topic of the images."""
        return resolved(named_image_topic(self.camera, self.settings.image_topic))

    @property
    def fusion_topic(self) -> str:
        """Topic of the first kind of message to fusion, detections for example."""
        return f'/{self.camera}/{self.kinds[0].TOPIC}'


@dataclass(frozen=True, eq=False, slots=True)
class CameraResult:
    """
    What a camera made of one image.

    Attributes
    ----------
    camera : str
        Its name.
    messages : mapping of str to Message
        What it publishes, by topic below its own.
    events : Events
        Its own events.
    feedback_missed : bool
        Whether it had to do without feedback.
    session : int
        How often time had begun anew before.

    """

    camera: str
    messages: Mapping[str, Message]
    events: Events
    feedback_missed: bool
    session: int = 0

    @property
    def stamp_ns(self) -> int:
        """Stamp of the image, ns."""
        return self.events.stamp_ns

    def tick(self, period_ns: int) -> int:
        """Return the number of its tick, over all sessions."""
        return self.session * SESSION + self.stamp_ns // period_ns


def topic_of(task: CameraTask, reader: BagReader) -> str:
    """
    Return the topic that a camera is replayed from: images, else recorded detections.

    Raises
    ------
    BagError
        If the bag holds neither.

    """
    for topic in (task.image_topic, task.fusion_topic):
        if reader.count(topic):
            return topic
    raise BagError(
        f'{task.bag} has no messages on {task.image_topic} nor on {task.fusion_topic}: '
        f'{_where_to_look(task, reader)}'
    )


def _where_to_look(task: CameraTask, reader: BagReader) -> str:
    """Return what a bag holds instead of a camera's topics, and how to track that."""
    filled = [topic for topic in reader.topics if reader.count(topic)]
    for wanted in (task.image_topic, task.fusion_topic):
        for topic in filled:
            if topic.endswith(wanted) and not topic.startswith('/truth/'):
                namespace = topic.removesuffix(wanted)
                return f'it has {topic}: give --namespace {namespace}'
    images = [topic for topic in filled if reader.topics[topic] in _IMAGES]
    detections = [topic for topic in filled if topic.endswith('/detections')]
    ending = f'/{task.settings.image_topic}' if images else '/detections'
    found = {topic.removesuffix(ending)[1:] for topic in images or detections}
    cameras = sorted(found - {'truth'})
    if cameras and all(map(is_name, cameras)):
        return f'its cameras are {", ".join(cameras)}; give the site of these, by --site'
    if images:
        return (
            f'its images are on {", ".join(sorted(images))}; name them in the site, each as '
            'image_topic of a camera'
        )
    return 'it has neither images nor detections of any camera'


class CameraSource:
    """
    Step one camera through a bag or a video.

    ``next_stamp_ns`` is the stamp of the image that `step` takes next; None at the end.
    ``session`` counts how often time had begun anew before it. ``quality`` says what the images
    were good for so far.

    Parameters
    ----------
    task : CameraTask
        Which camera, and where its images are.

    """

    def __init__(self, task: CameraTask) -> None:
        self._task = task
        self._reading: VideoReading | None = None
        self._messages = self._open()
        if self._from_images:
            settings = task.settings
            spread = task.first_pass and camera_method(settings.pipeline).first_pass
            background = plate_of(task) if spread and not settings.background else None
            self._pipeline = settings.open(task.camera, background)
        self._buffer = self._new_buffer()
        self._watch, self._overlay = ImageWatch(), Overlay()
        self._next_debug_ns = 0
        self.quality = CameraQuality(task.camera)
        self.next_stamp_ns: int | None = None
        self.session, self._read = 0, 0
        self._advance()

    def _open(self) -> Iterator[tuple[Any, ...]]:
        """Open the bag or the video; return the messages of each image."""
        video = self._task.video
        if video is not None:
            self._from_images, self._reading = True, video.reading()
            return ((message,) for _, message, _ in video.messages(self._reading))
        self._reader = BagReader(self._task.bag, self._task.namespace)
        topic = topic_of(self._task, self._reader)
        self._from_images = topic == self._task.image_topic
        if self._from_images:
            return ((message,) for _, message, _ in self._reader.messages([topic]))
        topics = [f'/{self._task.camera}/{kind.TOPIC}' for kind in self._task.kinds]
        return _of_one_image(self._reader, topics)

    def _new_buffer(self) -> RowsBuffer[Any]:
        """Return a buffer without feedback."""
        task = self._task
        return open_buffer(task.settings.pipeline, task.period_ns, task.delay_ns)

    def notes(self) -> list[str]:
        """Return the notes about the video so far, a line each."""
        return self._reading.notes() if self._reading else []

    def fault(self) -> str:
        """Return why a video that was read to its end is incomplete; empty: it is complete."""
        return self._reading.fault() if self._reading else ''

    @property
    def next_tick(self) -> int:
        """Number of the tick of the next image, over all sessions."""
        assert self.next_stamp_ns is not None
        return self.session * SESSION + self.next_stamp_ns // self._task.period_ns

    @property
    def wanted_tick(self) -> int:
        """Number of the tick whose feedback the next image uses."""
        assert self.next_stamp_ns is not None
        wanted_ns = self.next_stamp_ns - self._task.delay_ns
        return self.session * SESSION + wanted_ns // self._task.period_ns

    def push(self, feedback: Rows, session: int) -> None:
        """Hand over feedback of a tick of a session."""
        if session == self.session:
            self._buffer.push(feedback)

    def step(self) -> CameraResult:
        """Process the next image."""
        stamp_ns, session = self.next_stamp_ns, self.session
        assert stamp_ns is not None
        quality, name = self.quality, self._task.camera
        if self._from_images:
            feedback, missed = self._buffer.select(stamp_ns)
            state = self._watch.look(self._image, stamp_ns)
            quality.unusable += state is not ImageState.USABLE
            output = self._pipeline.step(self._image, stamp_ns, feedback)
            quality.unsettled += not output.is_settled
            moved = output.shift.state is ShiftState.MOVED
            quality.moved_px = output.shift.size_px if moved else 0.0
            self._draw(output)
            result = CameraResult(name, output.messages, output.events, missed, session)
        else:
            messages = {topic: message.at(stamp_ns) for topic, message in self._decoded.items()}
            result = CameraResult(name, messages, Events.build(stamp_ns), False, session)
        quality.messages += 1
        quality.detections += sum(map(_seen, result.messages.values()))
        self._advance()
        return result

    def _draw(self, output: CameraOutput) -> None:
        """Write the image with its detections, if one is due."""
        debug, stamp_ns = self._task.debug, output.events.stamp_ns
        if debug is None or 0 <= self._next_debug_ns - stamp_ns < debug.every_s * SECOND_NS:
            return
        self._next_debug_ns = stamp_ns + round(debug.every_s * SECOND_NS)
        groups, predicted = self._pipeline.groups(), self._pipeline.predicted_boxes()
        image = without_faces(self._image, output, predicted) if debug.blur else self._image
        drawn = self._overlay.draw(image, output.detections, output.events, groups, predicted)
        folder = debug.folder / self._task.camera
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f'{stamp_ns}.jpg').write_bytes(jpeg_from_image(drawn))

    def _advance(self) -> None:
        """Read ahead by one message; skip what the camera node would refuse."""
        session = self.session
        for messages in self._messages:
            stamp_ns = self._judged(messages[0])
            if stamp_ns != LEFT_OUT and self._is_usable(messages):
                self.next_stamp_ns = stamp_ns
                if session != self.session:
                    self._buffer = self._new_buffer()
                return
        quality, is_first = self.quality, self.next_stamp_ns is None
        self.next_stamp_ns = None
        if self._reading is None:
            self._reader.close()
        if is_first and quality.refused:
            place = '' if self._reading else f' on {self._task.image_topic}'
            raise BagError(f'{self._task.bag}: no image{place} can be used: {quality.reason}')

    def _judged(self, message: object) -> int:
        """Return the stamp of the message read last as it is used, ns, and note its session."""
        index, stamps = self._read, self._task.stamps
        self._read += 1
        if stamps is None:
            ahead_ns = self._task.settings.ahead_ns if self._task.video else 0
            return stamp_ns_of(message) - ahead_ns
        self.session = (
            stamps.session[index] if stamps.stamp_ns[index] != LEFT_OUT else self.session
        )
        return stamps.stamp_ns[index]

    def _is_usable(self, messages: tuple[Any, ...]) -> bool:
        """Decode messages; return whether this succeeds and an image has the camera's size."""
        settings, kinds = self._task.settings, self._task.kinds
        try:
            if self._from_images:
                size = (settings.image_width, settings.image_height)
                self._image = image_from_message(messages[0], size)
            else:
                if len(messages) < len(kinds):
                    raise ValueError(f'it lacks {kinds[-1].TOPIC}')
                decoded = (message_from_ros(*each) for each in zip(messages, kinds))
                self._decoded = {message.TOPIC: message for message in decoded}
        except ValueError as error:
            self.quality.refused += 1
            self.quality.reason = str(error)
            return False
        return True


def _of_one_image(reader: BagReader, topics: list[str]) -> Iterator[tuple[Any, ...]]:
    """
    Yield each image's messages, one a topic, in the order of the first topic.

    Of an image of which not all is there the first message is yielded alone.
    """
    first, others = topics[0], topics[1:]
    waiting: deque[Any] = deque()
    heard: dict[str, dict[int, Any]] = {topic: {} for topic in others}

    def taken() -> tuple[Any, ...]:
        message = waiting.popleft()
        parts = [heard[topic].pop(stamp_ns_of(message), None) for topic in others]
        return (message,) if None in parts else (message, *parts)

    def is_complete() -> bool:
        stamp_ns = stamp_ns_of(waiting[0])
        return all(stamp_ns in heard[topic] for topic in others)

    for topic, message, _ in reader.messages(topics):
        if topic == first:
            waiting.append(message)
        else:
            heard[topic][stamp_ns_of(message)] = message
            if len(heard[topic]) > MOST_WAITING:
                del heard[topic][next(iter(heard[topic]))]
        while waiting and (len(waiting) > MOST_WAITING or is_complete()):
            yield taken()
    while waiting:
        yield taken()


def _seen(message: Message) -> int:
    """Return how many rows are of somebody: of detections, those with a score."""
    if isinstance(message, Detections):
        return int((message.score > 0).sum())
    return len(message) if isinstance(message, Rows) else 0


def plate_of(task: CameraTask) -> Image | None:
    """
    Return the background of a camera of a bag or video.

    Parameters
    ----------
    task : CameraTask
        The camera, and where its images are.

    Returns
    -------
    (h, w, 3) uint8 array or None
        None: the recording holds too few images that can be used.

    """
    images = list(_spread(task))
    return spread_median(images) if len(images) >= LEAST_IMAGES else None


def _spread(task: CameraTask) -> Iterator[Image]:
    """Yield images spread evenly over a recording."""
    size = task.settings.image_width, task.settings.image_height
    if task.video is not None:
        yield from _of_video(task.video.video, size)
        return
    with BagReader(task.bag, task.namespace) as reader:
        count = reader.count(task.image_topic)
        step = max(count // SPREAD_IMAGES, 1)
        for index, (_, message, _) in enumerate(reader.messages([task.image_topic])):
            if index % step:
                continue
            try:
                image = image_from_message(message, size)
            except ValueError:
                continue
            if not is_blank(image):
                yield image


def _of_video(video: Video, size: tuple[int, int]) -> Iterator[Image]:
    step = max(video.stated // SPREAD_IMAGES, 1)
    for index, image in enumerate(video.images()):
        if index % step == 0 and image.shape[1::-1] == size and not is_blank(image):
            yield image
