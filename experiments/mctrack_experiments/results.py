"""The page of results: every measured figure beside its target and what others reach."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from mctrack_experiments.targets import TARGETS
from mctrack_ros.evaluation.figures import Figures, text_of
from mctrack_ros.report.targets import Target

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
    parts = [
        '# Results',
        'Made by `mctrack results` from the files in `docs/results/`; do not edit. Each section '
        'names the command that makes its figures again, and what they hold for. Peers are '
        'anchors on the same data; where their protocol differs the anchor says so.',
        '## Targets',
        *_target_table(results),
    ]
    for figures in results:
        parts += _section(figures)
    return '\n\n'.join(parts) + '\n'


def write_results(folder: str | Path, page: str | Path) -> None:
    """Write the page of all figures in a folder."""
    Path(page).write_text(results_page(read_results(folder)), encoding='utf-8')


def _target_table(results: Sequence[Figures]) -> list[str]:
    """Return the table of what has a bound, measured or not."""
    measured = {
        (figures.name, name): value
        for figures in results
        for name, value in figures.figures.items()
    }
    rows = []
    for target in TARGETS:
        if not target.text:
            continue
        value = measured.get((target.experiment, target.figure))
        shown = 'not measured' if value is None else text_of(value)
        met = '' if value is None else _MARKS[target.is_met(value)]
        rows.append((target.experiment, target.label, shown, target.text, met))
    return [_table(('experiment', 'figure', 'value', 'target', 'met'), rows)]


def _section(figures: Figures) -> list[str]:
    targets = {t.figure: t for t in TARGETS if t.experiment == figures.name}
    rows = [
        _row(name, value, targets.get(name, Target(figures.name, name, '')))
        for name, value in figures.figures.items()
    ]
    protocol = '; '.join(f'{name}: {_text(value)}' for name, value in figures.protocol.items())
    return [
        f'## {figures.name}',
        f'`{figures.command}`',
        f'{protocol}.',
        _table(('figure', 'value', 'target', 'met', 'anchor'), rows),
    ]


def _row(name: str, value: float, target: Target) -> tuple[str, ...]:
    met = _MARKS[target.is_met(value)]
    return f'`{name}`', text_of(value), target.text, met, target.anchor


def _table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [titles, ['---'] * len(titles), *rows]
    return '\n'.join('| ' + ' | '.join(_text(cell) for cell in line) + ' |' for line in lines)


def _text(value: object) -> str:
    """Return a value as it may stand in a table."""
    return str(value).replace('|', '\\|').replace('\n', ' ')
