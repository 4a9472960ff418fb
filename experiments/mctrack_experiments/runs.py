"""Measured runs of experiments whose scenes come from seeds: fresh seeds each time, all kept."""

from __future__ import annotations

import json
import math
import re
import statistics
import time
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from mctrack_experiments.definitions import definition_of
from mctrack_experiments.targets import TARGETS
from mctrack_ros.evaluation.figures import Figures, text_of

SEEDS: Mapping[str, int] = {
    'table4': 5,
    'pairs': 5,
    'fig14': 8,
    'fig16': 6,
    'robustness': 2,
    'feedback': 3,
    'covering': 5,
    'silhouettes': 4,
    'classes': 4,
    'grey_carpark': 5,
    'grid': 3,
    'hall': 3,
    'views': 3,
    'scenarios': 50,
    'consistency': 50,
    'biased': 8,
    'clocks': 50,
    'demo': 5,
    'moving_camera': 4,
    'belief': 20,
    'bench_fusion': 24,
    'bench_zones': 8,
    'bench_cells': 6,
}
"""How many seeds a run of each experiment has."""
SEEDS_APART = 1000
"""Seeds of the k-th run begin above k times so many; those below were tuned on, or are worn."""


class RunsError(ValueError):
    """A file that holds no runs; names the file and the reason."""


@dataclass(frozen=True, slots=True)
class Run:
    """
    One run on seeds that nothing was tuned on.

    Attributes
    ----------
    experiment : str
        Of which experiment.
    number : int
        The how many-th of it; 0: from before seeds were fresh.
    date : str
        Day, UTC.
    definition : int
        Of the experiment, see `definitions`.
    seeds : str
        Its seeds, as ``--seeds`` takes them.
    figures : mapping of str to float
        Those that have a target and a value; all, if none has a target.

    """

    experiment: str
    number: int
    date: str
    definition: int
    seeds: str
    figures: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Spread:
    """Mean and standard deviation of a figure over runs; not a number where there is one."""

    runs: int
    mean: float
    deviation: float

    def __str__(self) -> str:
        """Return mean, deviation and number of runs."""
        apart = f' ± {text_of(self.deviation)}' if self.runs > 1 else ''
        return f'{text_of(self.mean)}{apart} ({self.runs})'


def seeds_of(experiment: str, number: int) -> tuple[int, ...]:
    """Return the seeds of a run, 1000 k + i."""
    return tuple(SEEDS_APART * number + i for i in range(1, SEEDS[experiment] + 1))


def next_number(runs: Sequence[Run], experiment: str) -> int:
    """Return which run of an experiment the next is, from 1."""
    return 1 + max((run.number for run in runs if run.experiment == experiment), default=0)


def measured(
    experiment: str, given: str | None, path: Path, measure: Callable[[Sequence[int]], Figures]
) -> tuple[Figures, str]:
    """
    Measure on fresh seeds and keep the run, or on those given.

    Parameters
    ----------
    experiment : str
        What is measured.
    given : str or None
        Seeds, as ``--seeds`` takes them; None: those of the next run.
    path : Path
        The file of runs.
    measure : callable
        Seeds -> figures.

    Returns
    -------
    figures : Figures
        Their command makes them again; their protocol says what they mean.
    spread : str
        Mean and spread over all runs, if it is one of them.

    Raises
    ------
    OSError
        If there is no folder to keep the run in; nothing is measured then.

    """
    if given is None and not path.parent.is_dir():
        raise OSError(
            f'no folder {path.parent} to keep the run in: name the file with --runs, '
            'or the seeds with --seeds'
        )
    number = next_number(read_runs(path), experiment)
    seeds = seeds_of(experiment, number) if given is None else numbers(given)
    figures = measure(seeds)
    figures = replace(
        figures,
        command=f'{figures.command} --seeds {listed(seeds)}',
        protocol={**figures.protocol, 'definition': definition_of(experiment)},
    )
    if given is not None:
        return figures, ''
    runs = [*read_runs(path), run_of(figures, number, seeds)]
    write_runs(runs, path)
    return figures, spread_table(runs, experiment)


def run_of(figures: Figures, number: int, seeds: Sequence[int]) -> Run:
    """Return what is kept of a run's figures."""
    name = figures.name
    wanted = {target.figure for target in TARGETS if target.experiment == name}
    kept = {
        figure: float(value)
        for figure, value in figures.figures.items()
        if (figure in wanted or not wanted) and math.isfinite(value)
    }
    today = time.strftime('%Y-%m-%d', time.gmtime())
    return Run(name, number, today, definition_of(name), listed(seeds), kept)


def read_runs(path: Path) -> list[Run]:
    """
    Read a file of runs; none if there is no file.

    Raises
    ------
    RunsError
        If the file holds something else.

    """
    if not path.exists():
        return []
    try:
        return [Run(**each) for each in json.loads(path.read_text())]
    except (TypeError, ValueError) as error:
        raise RunsError(f'{path} holds no runs: {error!r}') from error


def write_runs(runs: Sequence[Run], path: Path) -> None:
    """Write a file of runs, a run a line, so that versions of it merge and compare well."""
    lines = ',\n'.join(json.dumps(asdict(run), allow_nan=False) for run in runs)
    path.write_text(f'[\n{lines}\n]\n')


def spread_of(runs: Sequence[Run], experiment: str, figure: str) -> Spread | None:
    """Return a figure's spread over all runs that the present definition holds for, if any."""
    values = [
        run.figures[figure]
        for run in runs
        if run.experiment == experiment
        and run.number
        and run.definition == definition_of(experiment)
        and figure in run.figures
    ]
    if not values:
        return None
    deviation = statistics.stdev(values) if len(values) > 1 else math.nan
    return Spread(len(values), statistics.fmean(values), deviation)


def spread_table(runs: Sequence[Run], experiment: str) -> str:
    """Return mean and spread of an experiment's figures over its runs, a line each."""
    names = [target.figure for target in TARGETS if target.experiment == experiment]
    found = [(name, spread_of(runs, experiment, name)) for name in names]
    lines = [f'  {name}  {spread}' for name, spread in found if spread is not None]
    return '\n'.join([f'{experiment}, mean ± standard deviation (runs)', *lines])


def medians(runs: Sequence[Mapping[str, float]], spread: Container[str]) -> dict[str, float]:
    """Return the medians of figures over runs, and the extremes of some of them."""
    figures: dict[str, float] = {}
    for name in runs[0]:
        values = [run[name] for run in runs]
        figures[name] = statistics.median(values)
        if name in spread:
            figures |= {f'{name}.least': min(values), f'{name}.most': max(values)}
    return figures


def listed(seeds: Sequence[int]) -> str:
    """Return seeds as ``--seeds`` takes them, for example ``1001-1005``."""
    if len(seeds) > 1 and list(seeds) == list(range(seeds[0], seeds[-1] + 1)):
        return f'{seeds[0]}-{seeds[-1]}'
    return ','.join(map(str, seeds))


def numbers(text: str) -> tuple[int, ...]:
    """
    Return the numbers that a text lists, as ``1-3`` or ``1,2,5-7``.

    Raises
    ------
    ValueError
        If it lists none or anything else.

    """
    found: list[int] = []
    for item in text.split(','):
        match = re.fullmatch(r'(\d+)(?:-(\d+))?', item)
        if match is None or int(match[2] or match[1]) < int(match[1]):
            raise ValueError(f'{text!r} lists no numbers, expected for example 11-34 or 1,2,3')
        first, last = match.groups()
        found += range(int(first), int(last or first) + 1)
    return tuple(found)
