"""Charts of a run, as SVG that takes its colours from the page."""

from __future__ import annotations

import base64
import io
from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, MultipleLocator
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from mctrack_ros.ground.coverage.coverage import Coverage
from mctrack_ros.recording.tables.columns import TableError
from mctrack_ros.recording.tracks.pitch import Pitch
from mctrack_ros.report.charts import ACCENT, INK, WARNING, new_chart, svg_of
from mctrack_ros.report.coverage_image import coverage_figure
from mctrack_ros.report.ground_plan import hex_colour, pitch_lines
from mctrack_ros.report.run.clock import clock
from mctrack_ros.report.run.data import CELL_M, RunData, TrackData
from mctrack_ros.simulation import LENGTH_M, WIDTH_M

Floats = NDArray[np.float64]

_HEAT = LinearSegmentedColormap.from_list(
    'heat', ['#0d8a5f00', '#4fb286', '#f2d544', '#f08c2e', '#c9302c']
)
_SMOOTH_M, _LEAST_SMOOTH = 0.9, 0.7
"""Standard deviation by which heat is smoothed, m, and at least, cells."""
_MOST_CELLS = 170
_OUTLIERS = 0.002
"""Share of the time, at either end of an axis, that no map is made wider for."""
_HOTTEST = 0.995
"""Share of the filled cells that the scale shows; hotter ones are as the hottest."""
_MARGIN_M = 3.0
_BINS = 150
_STEPS_S = (1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10_800, 21_600)
_TICKS = 12
_PANEL_IN, _TALLEST_IN = 3.1, 6.1
_SAME_M = 1.0


class Ground:
    """
    The ground that all maps of a report show.

    Parameters
    ----------
    data : RunData
        Of which tracks.

    """

    def __init__(self, data: RunData) -> None:
        self._lines = _lines(data.area)
        if data.area is not None:
            low, high = data.area.min(axis=0), data.area.max(axis=0)
        else:
            low, high = _bounds(data.tracks)
        low, high = low - _MARGIN_M, high + _MARGIN_M
        self.low, self.size = low, high - low
        self._cell = CELL_M * max(1, int(np.ceil(self.size.max() / CELL_M / _MOST_CELLS)))

    def heat(self, tracks: Sequence[TrackData]) -> Floats:
        """Return how long tracks were where, (rows, columns) s a square metre, smoothed."""
        shape = np.ceil(self.size / self._cell).astype(np.int64)
        heat = np.zeros(shape[::-1])
        for track in tracks:
            at = np.floor(((track.cells + 0.5) * CELL_M - self.low) / self._cell).astype(np.int64)
            inside = ((at >= 0) & (at < shape)).all(axis=1)
            np.add.at(heat, (at[inside, 1], at[inside, 0]), track.times[inside])
        smoothed: Floats = gaussian_filter(
            heat / self._cell**2, max(_SMOOTH_M / self._cell, _LEAST_SMOOTH)
        )
        return smoothed

    def draw(self, axes: Axes, heat: Floats, hottest: float) -> None:
        """Draw heat and the lines of the ground."""
        left, bottom = self.low
        extent = (
            left,
            left + heat.shape[1] * self._cell,
            bottom,
            bottom + heat.shape[0] * self._cell,
        )
        norm = Normalize(0, hottest)
        axes.imshow(
            heat, _HEAT, norm, origin='lower', extent=extent, interpolation='bilinear', zorder=1
        )
        axes.add_collection(LineCollection(self._lines, colors=INK, alpha=0.5, linewidths=0.8))
        axes.set_xlim(left, left + self.size[0])
        axes.set_ylim(bottom, bottom + self.size[1])
        axes.set_aspect('equal')
        axes.grid(visible=False)


def heat_chart(data: RunData, ground: Ground) -> str:
    """Draw how long anybody was where."""
    ratio = float(np.clip(ground.size[1] / ground.size[0], 0.25, 1.2))
    figure, axes = new_chart('heat', 10.0, min(9.0 * ratio, _TALLEST_IN))
    heat = ground.heat(data.tracks)
    hottest = _hottest(heat)
    ground.draw(axes, heat, hottest)
    axes.set_xlabel('x [m]')
    axes.set_ylabel('y [m]')
    bar = figure.colorbar(axes.images[0], ax=axes, shrink=0.7, pad=0.015, aspect=28)
    bar.set_label('time [s/m²]', color=INK)
    bar.ax.tick_params(colors=INK)
    bar.outline.set_visible(False)  # type: ignore[operator]
    return svg_of(figure, 'Heat map: how long anybody was where')


def track_heat_chart(track: TrackData, ground: Ground) -> str:
    """Draw how long one track was where."""
    ratio = float(np.clip(ground.size[1] / ground.size[0], 0.25, 1.6))
    figure, axes = new_chart(f'heat{track.summary.track_id}', 3.2, 3.2 * ratio)
    heat = ground.heat([track])
    ground.draw(axes, heat, _hottest(heat))
    axes.set_axis_off()
    return svg_of(figure, f'Heat map of track {track.summary.track_id}')


def presence_chart(tracks: Sequence[TrackData], between: tuple[float, float]) -> str:
    """Draw when each track was there."""
    figure, axes = new_chart('presence', 10.0, 0.9 + 0.19 * len(tracks))
    for row, track in enumerate(tracks):
        spans = [(began, max(ended - began, 0.0)) for began, ended in track.spells]
        axes.broken_barh(spans, (row - 0.36, 0.72), color=hex_colour(track.summary.track_id))
    axes.set_yticks(range(len(tracks)), [str(track.summary.track_id) for track in tracks])
    axes.tick_params(axis='y', labelsize=8, length=0)
    axes.set_ylim(len(tracks) - 0.4, -0.6)
    axes.set_ylabel('track')
    axes.grid(visible=False, axis='y')
    _time_axis(axes, between)
    return svg_of(figure, 'When each track was there')


def count_chart(data: RunData) -> str:
    """Draw how many tracks there were at once: mean, least and most."""
    figure, axes = new_chart('count', 10.0, 2.2)
    at, parts = _binned(data.times, data.between)
    counts = [data.present[part] for part in parts]
    low, mean, high = (
        [float(each(part)) if len(part) else np.nan for part in counts]
        for each in (np.min, np.mean, np.max)
    )
    axes.fill_between(at, low, high, color=ACCENT, alpha=0.25, linewidth=0)
    axes.plot(at, mean, color=ACCENT, linewidth=1.6)
    axes.set_ylim(bottom=0)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel('tracks at once')
    _time_axis(axes, data.between)
    return svg_of(figure, 'How many tracks there were at once')


def event_chart(data: RunData) -> str:
    """Draw when which events were: one by one where they are few, else how dense they are."""
    kinds: dict[str, list[float]] = defaultdict(list)
    for event in data.events:
        kinds[event.event].append(event.time_s)
    names = sorted(kinds, key=lambda name: (-len(kinds[name]), name))
    figure, axes = new_chart('events', 10.0, 0.9 + 0.36 * max(1, len(names)))
    first, last = data.between
    edges = np.linspace(first, max(last, first + 1e-3), _BINS + 1)
    for row, name in enumerate(names):
        times, colour = kinds[name], WARNING if name == 'correction' else ACCENT
        if len(times) <= _BINS:
            axes.vlines(times, row - 0.34, row + 0.34, color=colour, linewidth=1.2, alpha=0.85)
            continue
        counts, _ = np.histogram(times, edges)
        height = 0.7 * counts / counts.max()
        axes.bar(
            edges[:-1], height, np.diff(edges), row + 0.35 - height, align='edge', color=colour
        )
    labels = [f'{name.replace("_", " ")} ({len(kinds[name])})' for name in names]
    axes.set_yticks(range(len(names)), labels)
    axes.set_ylim(max(len(names), 1) - 0.5, -0.5)
    axes.tick_params(axis='y', length=0)
    axes.grid(visible=False, axis='y')
    _time_axis(axes, data.between)
    return svg_of(figure, 'When which events were')


def coverage_image(coverage: Coverage) -> str:
    """Return the image of a site's coverage as a PNG ``data:`` address."""
    return _png(coverage_figure(coverage, '', _PANEL_IN))


def _png(figure: Figure) -> str:
    buffer = io.BytesIO()
    figure.savefig(buffer, format='png', bbox_inches='tight', dpi=110)
    return f'data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}'


def _hottest(heat: Floats) -> float:
    filled = heat[heat > 1e-3 * heat.max(initial=0.0)]
    return max(float(np.quantile(filled, _HOTTEST)) if len(filled) else 0.0, 1e-6)


def _lines(area: Floats | None) -> list[Floats]:
    """Return the lines of a site's area: a pitch's where it is as large as one."""
    if area is None:
        return []
    outline = [np.vstack([area, area[:1]])]
    try:
        pitch = Pitch.from_corners(area)
    except TableError:
        return outline
    if np.abs(np.subtract((pitch.length, pitch.width), (LENGTH_M, WIDTH_M))).max() > _SAME_M:
        return outline
    middle = np.array([LENGTH_M, WIDTH_M]) / 2
    return [pitch.to_ground(line - middle) for line in pitch_lines()]


def _bounds(tracks: Sequence[TrackData]) -> tuple[Floats, Floats]:
    """Return where tracks are, without those who are astray for an instant."""
    if not tracks:
        return np.zeros(2), np.array([LENGTH_M, WIDTH_M])
    places = (np.concatenate([track.cells for track in tracks]) + 0.5) * CELL_M
    times = np.concatenate([track.times for track in tracks]) + 1e-9
    low, high = np.zeros(2), np.zeros(2)
    for axis in range(2):
        order = np.argsort(places[:, axis])
        share = np.cumsum(times[order]) / times.sum()
        ends = np.searchsorted(share, [_OUTLIERS, 1 - _OUTLIERS])
        low[axis], high[axis] = places[order, axis][np.minimum(ends, len(order) - 1)]
    return low, high


def _binned(times: Floats, between: tuple[float, float]) -> tuple[Floats, list[NDArray[np.intp]]]:
    """Return the middles of equal parts of a time, and which times are in each: none in a gap."""
    count = max(1, min(_BINS, len(times) // 2))
    edges = np.linspace(between[0], max(between[1], between[0] + 1e-3), count + 1)
    edges[-1] += 1e-6
    bounds = np.searchsorted(times, edges)
    parts = [np.arange(first, last) for first, last in pairwise(bounds)]
    return (edges[:-1] + edges[1:]) / 2, parts


def _time_axis(axes: Axes, between: tuple[float, float]) -> None:
    axes.set_xlim(between[0], max(between[1], between[0] + 1.0))
    length = max(between[1] - between[0], 1.0)
    step = next((each for each in _STEPS_S if length / each <= _TICKS), length / _TICKS)
    axes.xaxis.set_major_locator(MultipleLocator(step))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: clock(value, 0)))
    axes.set_xlabel("time since the run's first tick")
