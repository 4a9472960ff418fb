"""One image of a camera: from an image file, a video, a bag or the running graph."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import image_from_message
from mctrack_ros.recording import BagReader, is_bag

if TYPE_CHECKING:
    from mctrack_ros.ros.topics.live_images import LiveImages

Image = NDArray[np.uint8]
LIVE = 'live'
"""The source that is the running graph."""
PATIENCE_S = 10.0
"""How long a live topic, and then its next image, is waited for, s."""
IMAGE_TYPES = ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage')
_COMPRESSED = '/compressed'
_TAKEN = 'image_raw'
"""Part of the name of what a camera takes, by ROS's custom; others are drawn or derived."""


class ImageError(ValueError):
    """A source that gives no image; names it and says why."""


def read_image(
    source: str | Path, camera: str, topic: str = '', patience_s: float = PATIENCE_S
) -> Image:
    """
    Return the first image, (height, width, 3) blue, green, red, of a source.

    Parameters
    ----------
    source : str or Path
        An image file, a video file, a bag, or ``live`` for the running graph.
    camera : str
        Whose topic is read, if there are several of images.
    topic : str
        The topic of the bag or the graph; found by its type and the camera's name unless given.
    patience_s : float
        How long a live topic, and then its next image, is waited for, s.

    Raises
    ------
    ImageError, BagError
        If there is no image.

    """
    if str(source) == LIVE:
        return _from_graph(camera, topic, patience_s)
    path = Path(source)
    if is_bag(path):
        return _from_bag(path, camera, topic)
    if not path.exists():
        raise ImageError(f'{path} does not exist')
    if topic:
        raise ImageError(f'{path} is no bag, so it has no topic {topic}')
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    return _from_video(path) if image is None else _bytes(image)


def _from_video(path: Path) -> Image:
    from mctrack_ros.recording.video.videos import VideoError, open_video

    try:
        return next(open_video(path, rate_hz=1.0).images())  # whatever its times
    except VideoError as error:
        raise ImageError(f'{path} is neither an image nor a video: {error}') from error


def _from_bag(path: Path, camera: str, topic: str) -> Image:
    with BagReader(path) as bag:
        name = topic or _topic_of(bag.topics, camera, str(bag.path))
        message = next(bag.messages([name]), None)
    if message is None:
        raise ImageError(f'{path}: {name} holds no message')
    _check_kind(message[1].__msgtype__, f'{path}: {name}')
    return image_from_message(message[1])


def _from_graph(camera: str, topic: str, patience_s: float) -> Image:
    from mctrack_ros.ros.topics.live_images import LiveImages

    with LiveImages() as graph:
        name = '/' + topic.lstrip('/') if topic else _live_topic(graph, camera, patience_s)
        kind = graph.wait_for(name, patience_s)
        if kind is None:
            raise ImageError(
                f'{graph.name}: nobody publishes {name} within {patience_s:g} s: start the '
                "camera's node, or look for the topic's true name"
            )
        _check_kind(kind, name)
        message = graph.next(name, kind, patience_s)
    if message is None:
        raise ImageError(
            f'{name} is published, but no image came within {patience_s:g} s: see whether the '
            'camera runs; raw images often get lost on the way, a compressed topic seldom'
        )
    return image_from_message(message)


def _live_topic(graph: LiveImages, camera: str, patience_s: float) -> str:
    topics = graph.topics(patience_s)
    if not topics:
        raise ImageError(
            f'{graph.name}: nobody publishes images within {patience_s:g} s: start the '
            "camera's node, or name an image file, a video or a bag"
        )
    return _topic_of(topics, camera, graph.name)


def _topic_of(topics: Mapping[str, str], camera: str, where: str) -> str:
    """Return the topic of images that is the camera's, or the only one."""
    fitting = image_topics(topics, camera)
    if len(fitting) != 1:
        found = ', '.join(sorted(n for n, kind in topics.items() if kind in IMAGE_TYPES)) or 'none'
        raise ImageError(
            f'{where}: which topic holds the images of {camera}? Name it by --topic '
            f'(topics of images: {found})'
        )
    return fitting[0]


def _check_kind(kind: str, where: str) -> None:
    if kind not in IMAGE_TYPES:
        raise ImageError(f'{where} holds no images but {kind}')


def _bytes(image: NDArray[np.generic]) -> Image:
    return np.asarray(image, np.uint8)


def image_topics(topics: Mapping[str, str], camera: str) -> list[str]:
    """
    Return the topics that may hold a camera's images; exactly one if it is clear which.

    Those with the camera's name in theirs, of these those that are called ``image_raw``; of a
    topic and its compressed twin the twin, which gets through more surely.

    Parameters
    ----------
    topics : mapping of str to str
        Message type by topic.
    camera : str
        Name of the camera.

    """
    found = sorted(name for name, kind in topics.items() if kind in IMAGE_TYPES)
    for word in (camera, _TAKEN):
        found = [name for name in found if word in name.split('/')] or found
    return [name for name in found if name + _COMPRESSED not in found]
