"""A site's coverage as an image: who sees what, and how well."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from mctrack_ros.ground.coverage.coverage import Coverage

Floats = NDArray[np.float64]

_COUNTS = ('#ffffff', '#dcebf7', '#a9cfe8', '#63a8d3', '#2a7ab9', '#0b4a8b', '#06305c')
_CAMERAS = ('#c1121f', '#e07a00', '#2b8a3e', '#7b2cbf', '#0b7285', '#a61e4d', '#5c4d00', '#364fc7')
_LABEL = {'boxstyle': 'round,pad=0.15', 'facecolor': 'white', 'alpha': 0.8, 'linewidth': 0}
_ERRORS = 'viridis_r'
_PANEL = 5.4
_MARGIN = 0.06
_NEAR = 0.5
"""How far outside the area, in its diagonals, a camera may stand and still be shown."""


def draw_coverage(coverage: Coverage, title: str, path: Path) -> None:
    """Write `coverage_figure` into a file; its ending names the format."""
    path.parent.mkdir(parents=True, exist_ok=True)
    coverage_figure(coverage, title).savefig(path, bbox_inches='tight')


def coverage_figure(coverage: Coverage, title: str, panel_in: float = _PANEL) -> Figure:
    """
    Draw how many cameras see each place, and the predicted error of one and of all.

    Parameters
    ----------
    coverage : Coverage
        As computed.
    title : str
        Above the image; may be empty.
    panel_in : float
        Longer side of each of the three maps, inches.

    """
    low, high = _limits(coverage)
    width, height = (high - low) / (high - low).max() * panel_in
    figure = Figure(figsize=(3 * width + 3.6, height + 1.9), layout='compressed', dpi=130)
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    if title:
        figure.suptitle(title)
    for axes in panels:
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect='equal', xlabel='x [m]')
    panels[0].set_ylabel('y [m]')
    _draw_counts(panels[0], coverage)
    best, fused = coverage.raster.best, coverage.raster.fused
    known = np.concatenate([best[np.isfinite(best)], fused[np.isfinite(fused)]])
    bounds = (known.min(), known.max()) if len(known) else (0.1, 1.0)
    for axes, error, name in (
        (panels[1], best, 'best single camera'),
        (panels[2], fused, 'all cameras fused'),
    ):
        axes.set_title(f'Position error, {name}')
        norm = LogNorm(bounds[0], max(bounds[1], 1.01 * bounds[0]))
        shown = axes.imshow(error, _ERRORS, norm, origin='lower', extent=coverage.raster.extent)
    _label_errors(figure.colorbar(shown, ax=panels[1:], shrink=0.9, pad=0.01))
    for axes in panels:
        _draw_cameras(axes, coverage, low, high)
        _draw_region(axes, coverage.area, facecolor='none', edgecolor='black', linewidth=1.2)
    return figure


def _limits(coverage: Coverage) -> tuple[Floats, Floats]:
    """Return the least and the greatest x and y to be shown, m."""
    bounds = np.reshape(coverage.area.bounds, (2, 2))
    diagonal = float(np.hypot(*(bounds[1] - bounds[0])))
    shown = [
        foot
        for foot in coverage.feet
        if np.isfinite(foot).all()
        and coverage.area.distance(shapely.Point(foot)) <= _NEAR * diagonal
    ]
    points = np.vstack([bounds, *shown])
    margin = _MARGIN * diagonal
    return points.min(axis=0) - margin, points.max(axis=0) + margin


def _draw_counts(axes: Axes, coverage: Coverage) -> None:
    most = max(int(coverage.raster.count.max(initial=0)), 1)
    shades = [_COUNTS[min(number, len(_COUNTS) - 1)] for number in range(most + 1)]
    norm = BoundaryNorm(np.arange(most + 2) - 0.5, most + 1)
    shown = np.where(coverage.raster.inside, coverage.raster.count, np.nan)
    image = axes.imshow(
        shown, ListedColormap(shades), norm, origin='lower', extent=coverage.raster.extent
    )
    axes.figure.colorbar(
        image, ax=axes, ticks=range(most + 1), label='cameras', shrink=0.9, pad=0.01
    )
    for piece in coverage.blind:
        _draw_region(axes, piece, facecolor='none', edgecolor='#c1121f', hatch='////', linewidth=0)
    hatched = '; hatched: none' if coverage.blind else ''
    axes.set_title(f'Cameras that see a place{hatched}')


def _label_errors(bar: Colorbar) -> None:
    """Name what the bar shows, and its numbers as they are, not as powers of ten."""
    bar.set_label('1 sigma along the worst direction [m]')
    bar.ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f'{value:g}'))
    bar.ax.yaxis.set_minor_formatter(NullFormatter())


def _draw_cameras(axes: Axes, coverage: Coverage, low: Floats, high: Floats) -> None:
    """Draw the cameras' outlines, and their names where they stand."""
    for index, (name, field, foot) in enumerate(
        zip(coverage.names, coverage.fields, coverage.feet)
    ):
        colour = _CAMERAS[index % len(_CAMERAS)]
        _draw_region(axes, field, facecolor='none', edgecolor=colour, linewidth=1.1, alpha=0.9)
        shown = bool((foot >= low).all() and (foot <= high).all())
        visible = field.intersection(shapely.box(*low, *high))
        if not shown and visible.is_empty:
            continue
        place = foot if shown else shapely.get_coordinates(visible.representative_point())[0]
        if shown:
            axes.plot(*foot, '^', color=colour, markersize=7, markeredgecolor='white')
        axes.annotate(
            name, place, xytext=(0, 7), textcoords='offset points', ha='center', fontsize=8,
            color=colour, fontweight='bold', annotation_clip=True,
            bbox=_LABEL,
        )  # fmt: skip


def _draw_region(axes: Axes, region: shapely.Geometry, **style: object) -> None:
    for polygon in shapely.get_parts(region):
        rings = [polygon.exterior, *polygon.interiors]
        outline = Outline.make_compound_path(
            *(Outline(shapely.get_coordinates(ring), closed=True) for ring in rings)
        )
        axes.add_patch(PathPatch(outline, **style))
