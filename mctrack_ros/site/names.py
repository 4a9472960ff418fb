"""What cameras and namespaces may be called, and where topics lie below them."""

from __future__ import annotations

import re

from mctrack_ros.config import ConfigError

_NAME = re.compile('(?!.*__)[A-Za-z_][A-Za-z0-9_]*')
_WHAT = 'letters, digits and single underscores, no digit first'


def check_camera_name(name: object) -> None:
    """
    Refuse what is no name of a camera.

    Raises
    ------
    ConfigError
        If ROS would take it for no part of a topic.

    """
    if not is_name(name):
        raise ConfigError(f'camera {name!r}: expected {_WHAT}, for example cam1')


def is_name(name: object) -> bool:
    """Tell whether ROS takes something for one part of a topic's name."""
    return isinstance(name, str) and _NAME.fullmatch(name) is not None


def namespace_of(text: str) -> str:
    """
    Return a namespace as it begins the names in it: ``/hall``, also for ``hall``; '' for none.

    Raises
    ------
    ConfigError
        If it is none.

    """
    parts = text.strip('/').split('/') if text.strip('/') else []
    for part in parts:
        if not is_name(part):
            raise ConfigError(f'namespace {text!r}: expected {_WHAT} in each part, as in /hall')
    return ''.join(f'/{part}' for part in parts)


def resolved(topic: str, namespace: str = '') -> str:
    """Return the whole name of a topic, as a node in a namespace (see `namespace_of`) has it."""
    return topic if topic.startswith('/') else f'{namespace}/{topic}'


def named_image_topic(camera: str, image_topic: str) -> str:
    """Return the topic of a camera's images: below its name, unless it is a whole name."""
    return image_topic if image_topic.startswith('/') else f'{camera}/{image_topic}'
