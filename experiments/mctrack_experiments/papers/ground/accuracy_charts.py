"""Images of Experiments I and II of the event-tracking paper: its Figures 17 and 18."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mctrack_experiments.papers.ground.accuracy import (
    IMAGE_SIZE,
    PATHS_M,
    SPACINGS_M,
    TABLE_K1,
    path_points,
    true_camera,
    visible_grid,
)
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground import CameraMapping

METHODS = {
    'fitted': ('fitted camera', '#1b7837'),
    'cell': ('projective cells', '#5aae61'),
    'homography': ('one homography', '#2166ac'),
    'iterated': ("the paper's grid", '#d6604d'),
    'plane1': ('plane 1 of [17]', '#b2abd2'),
    'plane2': ('plane 2 of [17]', '#8073ac'),
}
"""Label and colour of each method."""


def draw_table3(figures: Figures, path: Path) -> None:
    """Draw the camera's view with the paths, and the errors of all methods on each."""
    figure = Figure(figsize=(13, 5), layout='constrained')
    view, bars = figure.subplots(1, 2)
    _draw_view(view)
    width = 0.8 / (len(METHODS) + 1)
    names = [*METHODS, 'paper']
    for index, name in enumerate(names):
        label, colour = METHODS.get(name, ('the paper, its own pose', '#bbbbbb'))
        prefix = 'paper.iterated' if name == 'paper' else name
        height = [
            max(figures.figures[f'{prefix}.{track}.rmse_{axis}_m'] for axis in 'xy')
            for track in PATHS_M
        ]
        place = np.arange(len(PATHS_M)) + (index - len(names) / 2 + 0.5) * width
        bars.bar(place, height, width, label=label, color=colour)
    bars.set_yscale('log')
    bars.set_xticks(range(len(PATHS_M)), [name.replace('path', 'path ') for name in PATHS_M])
    bars.set_ylabel('RMSE, the worse axis [m]')
    bars.set_title('grid points 8 m apart, clicked to 0.5 px; k1 = -0.2')
    bars.set_ylim(top=200)
    bars.legend(fontsize=8, ncols=3, loc='upper center')
    figure.savefig(path, dpi=100)


def draw_fig18(figures: Figures, path: Path) -> None:
    """Draw how errors grow with the distance of the grid's points."""
    figure = Figure(figsize=(13, 4), layout='constrained')
    cases = [(lens, click) for lens in ('straight', 'distorted') for click in ('exact', 'clicked')]
    for axes, (lens, click) in zip(figure.subplots(1, 4, sharey=True), cases):
        for name, (label, colour) in METHODS.items():
            worst = [
                figures.figures.get(f'{lens}.{click}.grid{spacing}.{name}.rmse_max_m', np.nan)
                for spacing in SPACINGS_M
            ]
            axes.plot(SPACINGS_M, np.maximum(worst, 1e-4), 'o-', label=label, color=colour)
        axes.set_yscale('log')
        axes.set_xticks(SPACINGS_M)
        axes.set_xlabel('distance of grid points [m]')
        axes.set_title(f'{lens} lens, {click} points', fontsize=10)
    figure.axes[0].set_ylabel('RMSE of the worst path and axis [m]')
    figure.axes[-1].legend(fontsize=7)
    figure.savefig(path, dpi=100)


def _draw_view(axes: Axes) -> None:
    camera = CameraMapping(true_camera(TABLE_K1), IMAGE_SIZE)
    grid = camera.image_from_ground(visible_grid(camera, SPACINGS_M[0]))
    axes.plot(*grid.T, '+', color='grey', label='grid points')
    for name, points in path_points().items():
        pixel = camera.image_from_ground(points)
        axes.plot(*pixel.T, '.', markersize=4, label=name.replace('path', 'path '))
    axes.set(xlim=(0, IMAGE_SIZE[0]), ylim=(IMAGE_SIZE[1], 0), aspect='equal')
    axes.set(xlabel='px', ylabel='px', title='what the camera sees')
    axes.legend(fontsize=8, loc='upper left')
