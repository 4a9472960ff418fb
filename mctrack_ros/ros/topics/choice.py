"""Topics chosen by regular expressions of their names."""

from __future__ import annotations

import re
from dataclasses import dataclass

from mctrack_ros.config import ConfigError

EXPLANATIONS = re.compile('.*/explanation/(candidates|decisions)')
"""Where the fusion node says why, while somebody listens."""


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
