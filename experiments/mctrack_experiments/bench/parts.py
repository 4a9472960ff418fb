"""Parts of the fusion benchmark, by themselves: the command line names them in its help."""

from enum import StrEnum


class Part(StrEnum):
    """What can be measured alone."""

    SPEED = 'speed'
    WHOLE = 'whole'
    ACCURACY = 'accuracy'
    HOSTILE = 'hostile'
