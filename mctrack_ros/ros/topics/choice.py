"""Topics chosen by their names and types, and by what sites want recorded."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass

from mctrack_ros.config import ConfigError
from mctrack_ros.input_size import SITE

EXPLANATIONS = re.compile('.*/explanation/(candidates|decisions)')
"""Where the fusion node says why, while somebody listens."""
SITE_TYPE = 'std_msgs/msg/String'
_PICTURES = re.compile(r'/\w*(Image|Video|Packet)\w*$')
"""Image, CompressedImage, DisparityImage, CompressedVideo, the packets of video transports."""


@dataclass(frozen=True, slots=True)
class Awaited:
    """
    Topics that need subscribers before the start.

    Attributes
    ----------
    topics : Pattern
        Of their whole names.
    subscribers : int or None
        How many, be the topic of the bag or of the graph; None: one, of the bag's only.

    """

    topics: re.Pattern[str]
    subscribers: int | None

    @classmethod
    def parsed(cls, text: str) -> Awaited:
        """
        Read a regular expression and, after a blank, a number.

        Raises
        ------
        ConfigError
            If it is neither.

        """
        topics, _, number = text.partition(' ')
        if number and not number.isdigit():
            raise ConfigError(f'wait_for has {text!r}, expected a number after the blank')
        return cls(pattern(topics), int(number) if number else None)


def pattern(text: str) -> re.Pattern[str]:
    """
    Compile a regular expression of topic names.

    Raises
    ------
    ConfigError
        If it is none.

    """
    try:
        return re.compile(text)
    except re.error as error:
        raise ConfigError(f'{text!r} is not a regular expression: {error}') from error


def are_pictures(kinds: Sequence[str]) -> bool:
    """Tell whether messages of one of some types are pictures, by the types' names."""
    return any(_PICTURES.search(kind) for kind in kinds)


def is_private(description: str) -> bool:
    """Tell whether a site is private by what `/site` says; anything else says nothing."""
    if len(description) > SITE:
        return False
    try:
        said = json.loads(description)
    except (ValueError, RecursionError):
        return False
    return isinstance(said, dict) and said.get('private') is True
