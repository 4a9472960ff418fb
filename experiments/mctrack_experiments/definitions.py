"""What the figures of an experiment mean, counted: figures of an older meaning are marked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

_SEEDS = 'fresh seeds'
_CLICKS = 'grids clicked with half a pixel of noise'
_EMPTY = 'images of the empty pitch as a camera takes them'
_DEFAULTS = 'the pitch by package defaults'


@dataclass(frozen=True, slots=True)
class Definition:
    """
    What the present figures of an experiment mean.

    Attributes
    ----------
    number : int
        Which meaning this is, from 1.
    change : str
        What it has that the one before lacked.
    figures : tuple of str
        How the names begin of the figures that it concerns.

    """

    number: int
    change: str
    figures: tuple[str, ...] = ('',)


DEFINITIONS: Mapping[str, Definition] = {
    'table4': Definition(3, f'{_SEEDS}, {_CLICKS}, {_EMPTY}, {_DEFAULTS}; E1 learned live, too'),
    'pairs': Definition(3, f'{_SEEDS}, {_CLICKS}, {_EMPTY}, {_DEFAULTS}'),
    'fig14': Definition(2, f'{_SEEDS}, {_CLICKS}, {_EMPTY}'),
    'fig16': Definition(2, f'{_SEEDS}, {_CLICKS}, {_EMPTY}'),
    'robustness': Definition(3, f'{_SEEDS}, {_CLICKS}, {_DEFAULTS}, false detections count'),
    'feedback': Definition(2, f'{_SEEDS}, {_CLICKS}'),
    'covering': Definition(
        2,
        f'{_SEEDS}, {_CLICKS}, {_EMPTY}; the share of a tick counts gate, costs and C; '
        'lab6p by defaults',
        ('pitch.', 'carpark.', 'beside.', 'facing.', 'assignment.', 'lab6p.'),
    ),
    'silhouettes': Definition(2, f"{_SEEDS}, {_CLICKS}, the paper's own parameters beside"),
    'classes': Definition(2, f'{_SEEDS}, {_CLICKS}'),
    'scenarios': Definition(2, _SEEDS),
    'consistency': Definition(2, _SEEDS),
    'biased': Definition(2, _SEEDS),
    'bench_fusion': Definition(2, _SEEDS, ('base.', 'crowd.')),
    'demo': Definition(3, f'the median of five runs, {_SEEDS}, {_CLICKS}, {_DEFAULTS}'),
}
"""By experiment, where it has changed."""


def definition_of(experiment: str) -> int:
    """Return which meaning the figures of an experiment have now."""
    return DEFINITIONS[experiment].number if experiment in DEFINITIONS else 1


def is_outdated(experiment: str, figure: str, number: int) -> bool:
    """Tell whether a figure that was measured by a definition means something else today."""
    definition = DEFINITIONS.get(experiment)
    return (
        definition is not None
        and number < definition.number
        and figure.startswith(definition.figures)
    )
