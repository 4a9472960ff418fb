"""`mctrack reproduce`: figures on real data, each with its protocol."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from enum import StrEnum
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, cast

import typer

from mctrack_experiments.cli.options import RUNS
from mctrack_ros.cli.options import image_file

if TYPE_CHECKING:
    from mctrack_ros.evaluation.figures import Figures


class Experiment(StrEnum):
    """What can be reproduced."""

    PETS = 'pets'
    TERRACE = 'terrace'
    TERRACE4 = 'terrace4'
    STREET = 'street'
    FOREGROUND = 'foreground'
    VIEWS = 'views'
    LAB6P = 'lab6p'
    CMC = 'cmc'
    WILDTRACK = 'wildtrack'
    DEFAULTS = 'defaults'
    CAMERAS = 'cameras'
    TABLE3 = 'table3'
    FIG18 = 'fig18'
    HONESTY = 'honesty'
    CAMERA_SHIFT = 'camera_shift'
    SILHOUETTES = 'silhouettes'
    CLASSES = 'classes'
    GREY_CARPARK = 'grey_carpark'
    HALL = 'hall'
    TABLE4 = 'table4'
    FIG14 = 'fig14'
    FIG16 = 'fig16'
    FIG20 = 'fig20'
    ROBUSTNESS = 'robustness'
    PAIRS = 'pairs'
    INTEL = 'intel'
    SCENARIOS = 'scenarios'
    CONSISTENCY = 'consistency'
    FEEDBACK = 'feedback'
    COVERING = 'covering'
    BIASED = 'biased'
    CLOCKS = 'clocks'
    DEMO = 'demo'
    GRID = 'grid'
    MOVING_CAMERA = 'moving_camera'
    BELIEF = 'belief'


_SIMULATED = {
    Experiment.TABLE4: 'papers.event_tracking.table4',
    Experiment.FIG14: 'papers.event_tracking.fig14',
    Experiment.FIG16: 'papers.event_tracking.fig16',
    Experiment.PAIRS: 'papers.event_tracking.pairs',
    Experiment.ROBUSTNESS: 'papers.event_tracking.robustness',
    Experiment.SILHOUETTES: 'papers.silhouettes.table1',
    Experiment.CLASSES: 'papers.silhouettes.classes',
    Experiment.GREY_CARPARK: 'scenarios.grey_carpark',
    Experiment.HALL: 'scenarios.hall',
    Experiment.VIEWS: 'scenarios.changing_views',
    Experiment.COVERING: 'papers.covering.experiment',
    Experiment.SCENARIOS: 'scenarios.reproduce',
    Experiment.CONSISTENCY: 'scenarios.consistency',
    Experiment.FEEDBACK: 'scenarios.feedback',
    Experiment.BIASED: 'scenarios.biased',
    Experiment.CLOCKS: 'scenarios.clocks',
    Experiment.DEMO: 'live_demo',
    Experiment.MOVING_CAMERA: 'papers.belief.moving_camera',
    Experiment.BELIEF: 'papers.belief.comparison',
    Experiment.GRID: 'papers.likelihood_grid.experiment',
}
"""Modules of the experiments whose scenes come from seeds."""
_COUNTED = (
    *(Experiment.SCENARIOS, Experiment.CONSISTENCY, Experiment.BIASED, Experiment.CLOCKS),
    *(Experiment.SILHOUETTES, Experiment.CLASSES, Experiment.GREY_CARPARK, Experiment.BELIEF),
    Experiment.HALL,
    Experiment.VIEWS,
)
"""Those that tell how many scenes of how many are done; the others tell lines."""
DRAWN = (
    *(Experiment.TABLE3, Experiment.FIG18, Experiment.FIG20),
    *(Experiment.MOVING_CAMERA, Experiment.BELIEF),
)


def reproduce(
    experiment: Experiment = typer.Argument(..., help='Which experiment.'),
    data: Path | None = typer.Option(
        None, help='Folder of the real data; unless given, MCTRACK_DATA or ../shared/data.'
    ),
    seeds: str | None = typer.Option(
        None,
        help='Seeds of simulated scenes, for example 1001-1005; unless given, fresh ones, and '
        'the run is kept.',
    ),
    runs: Path = RUNS,
    json_file: Path | None = typer.Option(None, '--json', help='Also write the figures here.'),
    image: Path | None = typer.Option(
        None,
        callback=image_file,
        help='table3, fig18, fig20, moving_camera, belief: also draw them, as .png, .svg or .pdf; '
        'the last two as .png.',
    ),
    repeat: int = typer.Option(
        1, min=1, help='terrace4: so many runs that differ as in the field; figures are medians.'
    ),
    live: bool = typer.Option(
        False, '--live', help='terrace: play its videos into the running nodes instead.'
    ),
) -> None:
    """
    Measure on real data, matches, car parks, staged scenarios, mappings or moved cameras.

    Real data is needed by pets, terrace, terrace4, street, foreground, lab6p, cmc, wildtrack,
    defaults, cameras, intel, camera_shift, covering, grid, belief and clocks, the fusion benchmark
    by biased; others are simulated. docs/results.md has what each one gave. The k-th run of an
    experiment on simulated scenes has the seeds 1000 k + 1, 1000 k + 2 ...; mean and spread of all
    its runs are printed.
    """
    if image is not None and experiment not in DRAWN:
        raise ValueError(f'{experiment} has no image: leave --image away')
    if live and experiment is not Experiment.TERRACE:
        raise ValueError(f'{experiment} has no live run: leave --live away')
    if repeat > 1 and experiment is not Experiment.TERRACE4:
        raise ValueError(f'{experiment} has one run: leave --repeat away')
    if experiment in _SIMULATED:
        figures = _simulated(experiment, data, seeds, runs, image)
    elif seeds is not None:
        raise ValueError(f'{experiment} has no seeds to choose: leave --seeds away')
    else:
        figures = _live(data) if live else _experiment(experiment, data, image, repeat)
        typer.echo(figures.table())
    if json_file is not None:
        figures.write(json_file)


def _simulated(
    experiment: Experiment,
    data: Path | None,
    given: str | None,
    kept: Path,
    image: Path | None,
) -> Figures:
    """Run on the seeds given, or on fresh ones; tell what came of it."""
    from mctrack_experiments.runs import measured

    figures, spread = measured(
        experiment, given, kept, partial(_on_seeds, experiment, data, image)
    )
    typer.echo(figures.table())
    if spread:
        typer.echo(f'\n{spread}')
    return figures


def _accuracy(experiment: Experiment, image: Path | None) -> Figures:
    from mctrack_experiments.papers.ground.accuracy import reproduce_fig18, reproduce_table3
    from mctrack_experiments.papers.ground.accuracy_charts import draw_fig18, draw_table3

    is_table = experiment is Experiment.TABLE3
    figures = reproduce_table3() if is_table else reproduce_fig18()
    if image is not None:
        (draw_table3 if is_table else draw_fig18)(figures, image)
    return figures


def data_folder(given: Path | None) -> Path:
    """
    Return the folder of the real data.

    Raises
    ------
    OSError
        If it is not there; says how to name it.

    """
    folder = given or Path(os.environ.get('MCTRACK_DATA', '../shared/data'))
    if not folder.is_dir():
        raise OSError(f'no real data in {folder}: name their folder with --data or MCTRACK_DATA')
    return folder


def _experiment(
    experiment: Experiment, data: Path | None, image: Path | None, repeat: int
) -> Figures:
    if experiment is Experiment.HONESTY:
        from mctrack_experiments.papers.ground.honesty import reproduce_honesty

        return reproduce_honesty()
    if experiment is Experiment.FIG20:
        from mctrack_experiments.papers.event_tracking.fig20 import reproduce_fig20

        return reproduce_fig20(image)
    if experiment in (Experiment.TABLE3, Experiment.FIG18):
        return _accuracy(experiment, image)
    if experiment is Experiment.TERRACE4:
        from mctrack_experiments.real.terrace.four_cameras import reproduce_terrace4
        from mctrack_ros.cli.progress import progress_bar

        with progress_bar('runs') as progress:
            return reproduce_terrace4(data_folder(data), repeat, progress)
    if experiment is Experiment.DEFAULTS:
        from mctrack_experiments.real.defaults import reproduce_defaults
        from mctrack_ros.cli.progress import progress_bar

        with progress_bar('data sets') as progress:
            return reproduce_defaults(data_folder(data), progress)
    return _real_experiment(experiment)(data_folder(data))


def _on_seeds(
    experiment: Experiment, data: Path | None, image: Path | None, seeds: Sequence[int]
) -> Figures:
    """Run an experiment on scenes of some seeds."""
    from mctrack_ros.cli.progress import progress_bar

    module = import_module(f'mctrack_experiments.{_SIMULATED[experiment]}')
    run = getattr(module, f'reproduce_{experiment}')
    places = []
    if experiment in (Experiment.COVERING, Experiment.BELIEF, Experiment.CLOCKS, Experiment.GRID):
        places = [data_folder(data)]
    if experiment is Experiment.BIASED:
        from mctrack_experiments.bench.fusion import toolkit_folder

        places = [toolkit_folder()]
    if image is not None:
        run = partial(run, image=image)
    if experiment in _COUNTED:
        with progress_bar('scenes') as progress:
            return cast('Figures', run(*places, seeds, progress))
    return cast('Figures', run(*places, seeds, progress=_tell))


def _live(data: Path | None) -> Figures:
    from mctrack_experiments.real.terrace.live import track_terrace_live

    return track_terrace_live(data_folder(data))


def _tell(line: str) -> None:
    typer.echo(line, err=True)


def _real_experiment(experiment: Experiment) -> Callable[[Path], Figures]:
    from mctrack_experiments.real.cameras import reproduce_cameras
    from mctrack_experiments.real.foreground.comparison import reproduce_foreground
    from mctrack_experiments.real.intel import reproduce_intel
    from mctrack_experiments.real.pets import reproduce_pets
    from mctrack_experiments.real.stored import detections as real_data
    from mctrack_experiments.real.street import reproduce_street

    if experiment is Experiment.TERRACE:
        from mctrack_experiments.real.terrace.four_cameras import reproduce_terrace

        return reproduce_terrace
    if experiment is Experiment.CAMERA_SHIFT:
        from mctrack_experiments.real.camera_shift import reproduce_camera_shift

        return reproduce_camera_shift
    return {
        Experiment.INTEL: reproduce_intel,
        Experiment.FOREGROUND: reproduce_foreground,
        Experiment.PETS: reproduce_pets,
        Experiment.STREET: reproduce_street,
        Experiment.CAMERAS: reproduce_cameras,
        Experiment.LAB6P: real_data.reproduce_lab6p,
        Experiment.CMC: real_data.reproduce_cmc,
        Experiment.WILDTRACK: real_data.reproduce_wildtrack,
    }[experiment]
