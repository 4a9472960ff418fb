"""What a camera may be called: its topics lie below its name."""

from __future__ import annotations

import re

from mctrack_ros.config import ConfigError

_NAME = re.compile('[a-z][a-z0-9_]*')


def check_camera_name(name: object) -> None:
    """
    Refuse what is no name of a camera.

    Raises
    ------
    ConfigError
        If ROS would take it for no part of a topic, or it is written in another way.

    """
    if not (isinstance(name, str) and _NAME.fullmatch(name)):
        raise ConfigError(
            f'camera {name!r}: expected lower-case letters, digits and underscores, a letter '
            'first, for example cam1'
        )
