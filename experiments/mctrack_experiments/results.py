"""The page of results: one table of measured figures, their targets and what peers reach."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from mctrack_experiments.targets import TARGETS
from mctrack_ros.evaluation.figures import Figures, text_of
from mctrack_ros.report.targets import Target

_INTRODUCTION = """# Results

Measured figures, their targets, and what other trackers reach on the same data. Each experiment
links to a JSON file with the command that makes the figures, the protocol (frames, gate, area,
settings, what was tuned on what) and all other figures of the run. Where the protocol of a peer
differs, the table says so. `mctrack results` makes this page from those files; do not edit it."""

_TITLES = ('experiment', 'figure', 'value', 'target', 'met', 'peers')
_MARKS = {True: 'yes', False: '**no**', None: ''}


def read_results(folder: str | Path) -> list[Figures]:
    """
    Read all figures of a folder, by file name.

    Raises
    ------
    FiguresError
        If a file there holds none.

    """
    return [Figures.read(path) for path in sorted(Path(folder).glob('*.json'))]


def results_page(results: Sequence[Figures]) -> str:
    """
    Return the page, Markdown.

    Parameters
    ----------
    results : sequence of Figures
        One for each experiment.

    """
    measured = {
        (figures.name, name): value
        for figures in results
        for name, value in figures.figures.items()
    }
    rows = [_row(target, measured) for target in TARGETS if target.text or target.anchor]
    return f'{_INTRODUCTION}\n\n{_table(rows)}\n'


def write_results(folder: str | Path, page: str | Path) -> None:
    """Write the page of all figures in a folder."""
    Path(page).write_text(results_page(read_results(folder)), encoding='utf-8')


def _row(target: Target, measured: Mapping[tuple[str, str], float]) -> tuple[str, ...]:
    """Return the cells of a target; a figure that the anchor names is shown by its value."""

    def value_of(figure: str, otherwise: str) -> str:
        value = measured.get((target.experiment, figure))
        return otherwise if value is None else text_of(value)

    value = measured.get((target.experiment, target.figure))
    return (
        f'[{target.experiment}](results/{target.experiment}.json)',
        target.label,
        value_of(target.figure, 'not measured'),
        target.text,
        '' if value is None else _MARKS[target.is_met(value)],
        re.sub('`(.+?)`', lambda match: value_of(match[1], match[0]), target.anchor),
    )


def _table(rows: Iterable[Sequence[str]]) -> str:
    lines = [_TITLES, ['---'] * len(_TITLES), *rows]
    return '\n'.join('| ' + ' | '.join(_text(cell) for cell in line) + ' |' for line in lines)


def _text(value: str) -> str:
    """Return a value as it may stand in a table."""
    return value.replace('|', '\\|').replace('\n', ' ')
