"""`mctrack reproduce`: figures on real data, each with its protocol."""

from __future__ import annotations

import os
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mctrack_ros.cli.options import image_file

if TYPE_CHECKING:
    from mctrack_ros.evaluation.figures import Figures


class Experiment(StrEnum):
    """What can be reproduced."""

    PETS = 'pets'
    TERRACE = 'terrace'
    TERRACE4 = 'terrace4'
    LAB6P = 'lab6p'
    CMC = 'cmc'
    WILDTRACK = 'wildtrack'
    CAMERAS = 'cameras'
    TABLE3 = 'table3'
    FIG18 = 'fig18'
    HONESTY = 'honesty'
    WATCHDOG = 'watchdog'
    SILHOUETTES = 'silhouettes'
    CLASSES = 'classes'
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


DRAWN = (Experiment.TABLE3, Experiment.FIG18, Experiment.FIG20)


def reproduce(
    experiment: Experiment = typer.Argument(..., help='Which experiment.'),
    data: Path | None = typer.Option(
        None, help='Folder of the real data; unless given, MCTRACK_DATA or ../shared/data.'
    ),
    json_file: Path | None = typer.Option(None, '--json', help='Also write the figures here.'),
    image: Path | None = typer.Option(
        None,
        callback=image_file,
        help='table3, fig18, fig20: also draw them, as .png, .svg or .pdf.',
    ),
    live: bool = typer.Option(
        False, '--live', help='terrace: play its videos into the running nodes instead.'
    ),
) -> None:
    """
    Measure on real data, matches, the car park, staged scenarios, mappings or the watchdog.

    Real data is needed by pets, terrace, terrace4, lab6p, cmc, wildtrack, cameras, intel,
    watchdog and covering, the fusion benchmark by biased; the others are simulated.
    docs/results.md has what each one gave.
    """
    if image is not None and experiment not in DRAWN:
        raise ValueError(f'{experiment} has no image: leave --image away')
    if live and experiment is not Experiment.TERRACE:
        raise ValueError(f'{experiment} has no live run: leave --live away')
    figures = _live(data) if live else _experiment(experiment, data, image)
    typer.echo(figures.table())
    if json_file is not None:
        figures.write(json_file)


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


def _experiment(experiment: Experiment, data: Path | None, image: Path | None) -> Figures:
    if experiment is Experiment.HONESTY:
        from mctrack_experiments.papers.ground.honesty import reproduce_honesty

        return reproduce_honesty()
    if experiment is Experiment.SILHOUETTES:
        from mctrack_experiments.papers.silhouettes.table1 import reproduce_silhouettes

        return reproduce_silhouettes()
    if experiment is Experiment.CLASSES:
        from mctrack_experiments.papers.silhouettes.classes import reproduce_classes

        return reproduce_classes()
    if experiment is Experiment.TABLE4:
        from mctrack_experiments.papers.event_tracking.table4 import reproduce_table4

        return reproduce_table4(progress=_tell)
    if experiment is Experiment.FIG14:
        from mctrack_experiments.papers.event_tracking.fig14 import reproduce_fig14

        return reproduce_fig14(progress=_tell)
    if experiment is Experiment.FIG16:
        from mctrack_experiments.papers.event_tracking.fig16 import reproduce_fig16

        return reproduce_fig16(progress=_tell)
    if experiment is Experiment.PAIRS:
        from mctrack_experiments.papers.event_tracking.pairs import reproduce_pairs

        return reproduce_pairs(progress=_tell)
    if experiment is Experiment.ROBUSTNESS:
        from mctrack_experiments.papers.event_tracking.robustness import reproduce_robustness

        return reproduce_robustness(progress=_tell)
    if experiment is Experiment.SCENARIOS:
        from mctrack_experiments.scenarios.reproduce import reproduce_scenarios
        from mctrack_ros.cli.progress import progress_bar

        with progress_bar('scenes') as progress:
            return reproduce_scenarios(progress=progress)
    if experiment is Experiment.CONSISTENCY:
        from mctrack_experiments.scenarios.consistency import reproduce_consistency
        from mctrack_ros.cli.progress import progress_bar

        with progress_bar('scenes') as progress:
            return reproduce_consistency(progress=progress)
    if experiment is Experiment.FEEDBACK:
        from mctrack_experiments.scenarios.feedback import reproduce_feedback

        return reproduce_feedback(progress=_tell)
    if experiment is Experiment.BIASED:
        from mctrack_experiments.bench.fusion import toolkit_folder
        from mctrack_experiments.scenarios.biased import reproduce_biased
        from mctrack_ros.cli.progress import progress_bar

        with progress_bar('scenes') as progress:
            return reproduce_biased(toolkit_folder(), progress=progress)
    if experiment is Experiment.FIG20:
        from mctrack_experiments.papers.event_tracking.fig20 import reproduce_fig20

        return reproduce_fig20(image)
    if experiment in (Experiment.TABLE3, Experiment.FIG18):
        return _accuracy(experiment, image)
    if experiment is Experiment.COVERING:
        from mctrack_experiments.papers.covering import reproduce_covering

        return reproduce_covering(data_folder(data), progress=_tell)
    return _real_experiment(experiment)(data_folder(data))


def _live(data: Path | None) -> Figures:
    from mctrack_experiments.real.terrace_live import track_terrace_live

    return track_terrace_live(data_folder(data))


def _tell(line: str) -> None:
    typer.echo(line, err=True)


def _real_experiment(experiment: Experiment) -> Callable[[Path], Figures]:
    from mctrack_experiments.real import stored_detections as real_data
    from mctrack_experiments.real.cameras import reproduce_cameras
    from mctrack_experiments.real.intel import reproduce_intel
    from mctrack_experiments.real.pets import reproduce_pets

    if experiment in (Experiment.TERRACE, Experiment.TERRACE4):
        from mctrack_experiments.real.terrace import reproduce_terrace, reproduce_terrace4

        return reproduce_terrace if experiment is Experiment.TERRACE else reproduce_terrace4
    if experiment is Experiment.WATCHDOG:
        from mctrack_experiments.real.camera_shift import reproduce_watchdog

        return reproduce_watchdog
    return {
        Experiment.INTEL: reproduce_intel,
        Experiment.PETS: reproduce_pets,
        Experiment.CAMERAS: reproduce_cameras,
        Experiment.LAB6P: real_data.reproduce_lab6p,
        Experiment.CMC: real_data.reproduce_cmc,
        Experiment.WILDTRACK: real_data.reproduce_wildtrack,
    }[experiment]
