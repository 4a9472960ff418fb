"""Topics chosen by their names and types, and by what sites want recorded."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from mctrack_ros.config import ConfigError
from mctrack_ros.input_size import SITE

EXPLANATIONS = '.*/explanation/(candidates|decisions)'
"""Where the fusion node says why, while somebody listens."""
SITE_TYPE = 'std_msgs/msg/String'
_IMAGES = re.compile(r'/\w*(Image|Video|Packet)\w*$')
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


class TopicChoice:
    """
    Chooses topics by regular expressions, each of a whole name.

    Parameters
    ----------
    topics, types : iterable of str
        One of each must match, of the topic and of one of its types.
    exclude : iterable of str
        None of these may match the topic.

    Raises
    ------
    ConfigError
        If one is no regular expression.

    """

    def __init__(
        self, topics: Iterable[str], exclude: Iterable[str], types: Iterable[str] = ('.*',)
    ) -> None:
        self._topics, self._exclude, self._types = (
            [pattern(text) for text in each] for each in (topics, exclude, types)
        )

    def takes(self, topic: str, kinds: Sequence[str]) -> bool:
        """Tell whether a topic, of some types, is chosen."""
        return (
            not _fits(self._exclude, topic)
            and _fits(self._topics, topic)
            and any(_fits(self._types, kind) for kind in kinds)
        )


def _fits(patterns: Iterable[re.Pattern[str]], name: str) -> bool:
    return any(each.fullmatch(name) for each in patterns)


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


def are_images(kinds: Sequence[str]) -> bool:
    """Tell whether messages of one of some types are images, by the types' names."""
    return any(_IMAGES.search(kind) for kind in kinds)


def is_private(description: str) -> bool:
    """Tell whether a site is private by what `/site` says; anything else says nothing."""
    if len(description) > SITE:
        return False
    try:
        said = json.loads(description)
    except (ValueError, RecursionError):
        return False
    return isinstance(said, dict) and said.get('private') is True
