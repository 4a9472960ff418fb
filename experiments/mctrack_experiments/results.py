"""The page of results: one table of measured figures, their targets and what peers reach."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from mctrack_experiments.definitions import DEFINITIONS, is_outdated
from mctrack_experiments.real.defaults import defaults_table
from mctrack_experiments.runs import Run, read_runs, spread_of
from mctrack_experiments.targets import TARGETS
from mctrack_ros.evaluation.figures import Figures, text_of
from mctrack_ros.report.targets import Target

_INTRODUCTION = """# Results

Measured figures, their targets, and what other trackers reach on the same data. Each experiment
links to a JSON file with the command that makes the figures, the protocol (frames, gate, area,
settings, what was tuned on what) and all other figures of the run. Where the protocol of a peer
differs, the table says so. `mctrack results` makes this page from those files; do not edit it.

The k-th run of an experiment on simulated scenes has the seeds 1000 k + 1, 1000 k + 2 ...;
[all runs](runs.json) are kept, those on older seeds as run 0. "All runs" is the mean and standard
deviation of a figure over the runs by its present definition, and how many they are. A value
marked † was measured by an older definition and says nothing about the present one; below the
table is what has changed."""

_DEFAULTS = """## Defaults beside tuned settings

Figures of lab6p, CMC, PETS and WILDTRACK above are by package defaults and what any user states.
[Here](results/defaults.json) they stand beside those of settings that were tuned on these very
scores (‡), which no user could choose, and of the settings, of all that were tried, that suit the
others best. MOTA / IDF1, means of nine runs: detections as recorded, and moved by 2 cm."""

_TITLES = ('experiment', 'figure', 'value', 'all runs', 'target', 'met', 'peers')
_OUTDATED = '†'
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


def results_page(results: Sequence[Figures], runs: Sequence[Run] = ()) -> str:
    """
    Return the page, Markdown.

    Parameters
    ----------
    results : sequence of Figures
        One for each experiment.
    runs : sequence of Run
        All runs on fresh seeds.

    """
    measured = {
        (figures.name, name): value
        for figures in results
        for name, value in figures.figures.items()
    }
    by = {figures.name: int(figures.protocol.get('definition', 1)) for figures in results}
    rows, changed = [], {}
    for target in TARGETS:
        if target.text or target.anchor:
            name = target.experiment
            is_old = name in by and is_outdated(name, target.figure, by[name])
            rows.append(_row(target, measured, runs, is_old))
            if is_old:
                changed[name] = f'* † `{name}`, since changed: {DEFINITIONS[name].change}.'
    notes = ['', *changed.values()] if changed else []
    lines = [_INTRODUCTION, '', _table(rows), *notes]
    for figures in results:
        if figures.name == 'defaults':
            lines += ['', _DEFAULTS, '', *defaults_table(figures)]
    return '\n'.join(lines) + '\n'


def write_results(folder: str | Path, runs: str | Path, page: str | Path) -> None:
    """Write the page of all figures in a folder and of the runs in a file."""
    content = results_page(read_results(folder), read_runs(Path(runs)))
    Path(page).write_text(content, encoding='utf-8')


def _row(
    target: Target,
    measured: Mapping[tuple[str, str], float],
    runs: Sequence[Run],
    is_old: bool,
) -> tuple[str, ...]:
    """Return the cells of a target; a figure that the anchor names is shown by its value."""

    def value_of(figure: str, otherwise: str) -> str:
        value = measured.get((target.experiment, figure))
        return otherwise if value is None else text_of(value)

    value = measured.get((target.experiment, target.figure))
    spread = spread_of(runs, target.experiment, target.figure)
    met = '' if value is None else _MARKS[target.is_met(value)]
    return (
        f'[{target.experiment}](results/{target.experiment}.json)',
        target.label,
        value_of(target.figure, 'not yet' if is_old else 'not measured') + _OUTDATED * is_old,
        '' if spread is None else str(spread),
        target.text,
        'old definition' if is_old else met,
        re.sub('`(.+?)`', lambda match: value_of(match[1], match[0]), target.anchor),
    )


def _table(rows: Iterable[Sequence[str]]) -> str:
    lines = [_TITLES, ['---'] * len(_TITLES), *rows]
    return '\n'.join('| ' + ' | '.join(_text(cell) for cell in line) + ' |' for line in lines)


def _text(value: str) -> str:
    """Return a value as it may stand in a table."""
    return value.replace('|', '\\|').replace('\n', ' ')
