"""One picture of a camera: from a picture file, a video, a bag or the running graph."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import image_from_message
from mctrack_ros.recording import BagReader, is_bag
from mctrack_ros.web.picture_topic import IMAGE_TYPES, picture_topics

if TYPE_CHECKING:
    from mctrack_ros.ros.topics.live_images import LivePictures

Image = NDArray[np.uint8]
LIVE = 'live'
"""The source that is the running graph."""
PATIENCE_S = 10.0
"""How long a live topic, and then its next picture, is waited for, s."""


class PictureError(ValueError):
    """A source that gives no picture; names it and says why."""


def read_picture(
    source: str | Path, camera: str, topic: str = '', patience_s: float = PATIENCE_S
) -> Image:
    """
    Return the first picture, (height, width, 3) blue, green, red, of a source.

    Parameters
    ----------
    source : str or Path
        A picture file, a video file, a bag, or ``live`` for the running graph.
    camera : str
        Whose topic is read, if there are several of pictures.
    topic : str
        The topic of the bag or the graph; found by its type and the camera's name unless given.
    patience_s : float
        How long a live topic, and then its next picture, is waited for, s.

    Raises
    ------
    PictureError, BagError
        If there is no picture.

    """
    if str(source) == LIVE:
        return _from_graph(camera, topic, patience_s)
    path = Path(source)
    if is_bag(path):
        return _from_bag(path, camera, topic)
    if not path.exists():
        raise PictureError(f'{path} does not exist')
    if topic:
        raise PictureError(f'{path} is no bag, so it has no topic {topic}')
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    return _from_video(path) if picture is None else _bytes(picture)


def _from_video(path: Path) -> Image:
    from mctrack_ros.recording.video.file import VideoError, open_video

    try:
        return next(open_video(path, rate_hz=1.0).pictures())  # whatever its times
    except VideoError as error:
        raise PictureError(f'{path} is neither a picture nor a video: {error}') from error


def _from_bag(path: Path, camera: str, topic: str) -> Image:
    with BagReader(path) as bag:
        name = topic or _topic_of(bag.topics, camera, str(bag.path))
        message = next(bag.messages([name]), None)
    if message is None:
        raise PictureError(f'{path}: {name} holds no message')
    _check_kind(message[1].__msgtype__, f'{path}: {name}')
    return image_from_message(message[1])


def _from_graph(camera: str, topic: str, patience_s: float) -> Image:
    from mctrack_ros.ros.topics.live_images import LivePictures

    with LivePictures() as graph:
        name = '/' + topic.lstrip('/') if topic else _live_topic(graph, camera, patience_s)
        kind = graph.wait_for(name, patience_s)
        if kind is None:
            raise PictureError(
                f'{graph.name}: nobody publishes {name} within {patience_s:g} s: start the '
                "camera's node, or look for the topic's true name"
            )
        _check_kind(kind, name)
        message = graph.next(name, kind, patience_s)
    if message is None:
        raise PictureError(
            f'{name} is published, but no picture came within {patience_s:g} s: see whether the '
            'camera runs; raw pictures often get lost on the way, a compressed topic seldom'
        )
    return image_from_message(message)


def _live_topic(graph: LivePictures, camera: str, patience_s: float) -> str:
    topics = graph.topics(patience_s)
    if not topics:
        raise PictureError(
            f'{graph.name}: nobody publishes pictures within {patience_s:g} s: start the '
            "camera's node, or name a picture file, a video or a bag"
        )
    return _topic_of(topics, camera, graph.name)


def _topic_of(topics: Mapping[str, str], camera: str, where: str) -> str:
    """Return the topic of pictures that is the camera's, or the only one."""
    fitting = picture_topics(topics, camera)
    if len(fitting) != 1:
        found = ', '.join(sorted(n for n, kind in topics.items() if kind in IMAGE_TYPES)) or 'none'
        raise PictureError(
            f'{where}: which topic holds the pictures of {camera}? Name it by --topic '
            f'(topics of pictures: {found})'
        )
    return fitting[0]


def _check_kind(kind: str, where: str) -> None:
    if kind not in IMAGE_TYPES:
        raise PictureError(f'{where} holds no pictures but {kind}')


def _bytes(picture: NDArray[np.generic]) -> Image:
    return np.asarray(picture, np.uint8)
