"""Which topic of many holds a camera's images."""

from __future__ import annotations

from collections.abc import Mapping

IMAGE_TYPES = ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage')
_COMPRESSED = '/compressed'
_TAKEN = 'image_raw'
"""Part of the name of what a camera takes, by ROS's custom; others are drawn or derived."""


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
