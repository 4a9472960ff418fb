"""One picture of a camera: from a picture file, a video or a bag."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mctrack_ros.codec import image_from_message
from mctrack_ros.recording import BagReader

Image = NDArray[np.uint8]
IMAGE_TYPES = ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage')


class PictureError(ValueError):
    """A source that gives no picture; names it and says why."""


def read_picture(source: str | Path, camera: str, topic: str = '') -> Image:
    """
    Return the first picture, (height, width, 3) blue, green, red, of a source.

    Parameters
    ----------
    source : str or Path
        A picture file, a video file or a bag.
    camera : str
        Whose topic is read, if a bag has several of pictures.
    topic : str
        The topic of the bag; found by its type and the camera's name unless given.

    Raises
    ------
    PictureError, BagError
        If there is no picture.

    """
    path = Path(source)
    if path.is_dir():
        return _from_bag(path, camera, topic)
    if not path.exists():
        raise PictureError(f'{path} does not exist')
    if topic:
        raise PictureError(f'{path} is no bag, so it has no topic {topic}')
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    return _from_video(path) if picture is None else _bytes(picture)


def _from_video(path: Path) -> Image:
    capture = cv2.VideoCapture(str(path))
    try:
        found, picture = capture.read()
    finally:
        capture.release()
    if not found:
        raise PictureError(f'{path} is neither a picture nor a video that OpenCV reads')
    return _bytes(picture)


def _from_bag(path: Path, camera: str, topic: str) -> Image:
    with BagReader(path) as bag:
        name = topic or _topic_of(bag, camera)
        message = next(bag.messages([name]), None)
    if message is None:
        raise PictureError(f'{path}: {name} holds no message')
    if message[1].__msgtype__ not in IMAGE_TYPES:
        raise PictureError(f'{path}: {name} holds no pictures but {message[1].__msgtype__}')
    picture = image_from_message(message[1])
    return picture if picture.ndim == 3 else _bytes(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))


def _topic_of(bag: BagReader, camera: str) -> str:
    """Return the topic of pictures that is the camera's, or the only one."""
    topics = sorted(name for name, kind in bag.topics.items() if kind in IMAGE_TYPES)
    own = [name for name in topics if camera in name.split('/')]
    fitting = own or topics
    if len(fitting) != 1:
        found = ', '.join(topics) or 'none'
        raise PictureError(
            f'{bag.path}: which topic holds the pictures of {camera}? Name it by --topic '
            f'(topics of pictures: {found})'
        )
    return fitting[0]


def _bytes(picture: NDArray[np.generic]) -> Image:
    return np.asarray(picture, np.uint8)
