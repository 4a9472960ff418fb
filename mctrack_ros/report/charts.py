"""The report's charts, as SVG that takes its colours from the page."""

from __future__ import annotations

import io
import re
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mctrack_ros.evaluation import Timeline, Trajectories
from mctrack_ros.report.ground_plan import hex_colour, pitch_lines
from mctrack_ros.simulation import LENGTH_M, WIDTH_M

Floats = NDArray[np.float64]

INK = '#010203'
ACCENT = '#0d8a5f'
WARNING = '#d9480f'
MUTED = '#7a8594'
_PER_SECOND = 5
_JUMP_M = 3.0
_MARGIN_M = 3.0


def trajectory_chart(
    truth: Trajectories, tracks: Trajectories, line: Timeline, period_s: float
) -> str:
    """Draw true and estimated trajectories over the pitch, switches as crosses."""
    figure, axes = new_chart('trajectories', 10.0, 6.9)
    axes.add_collection(LineCollection(pitch_lines(), colors=INK, alpha=0.45, linewidths=0.9))
    step = max(1, round(1.0 / _PER_SECOND / period_s))
    true_paths, _ = _paths(truth, step)
    paths, ids = _paths(tracks, step)
    axes.add_collection(LineCollection(true_paths, colors=INK, alpha=0.28, linewidths=2.6))
    colours = [hex_colour(number) for number in ids]
    axes.add_collection(LineCollection(paths, colors=colours, linewidths=1.0))
    places = _switch_places(truth, line)
    axes.plot(places[:, 0], places[:, 1], 'x', color=WARNING, markersize=8, markeredgewidth=2)
    axes.set_xlim(-_MARGIN_M, LENGTH_M + _MARGIN_M)
    axes.set_ylim(-_MARGIN_M, WIDTH_M + _MARGIN_M)
    axes.set_aspect('equal')
    axes.set_axis_off()
    return svg_of(figure, 'True and estimated trajectories over the pitch')


def latency_chart(latency_ms: Floats) -> str:
    """Draw how long tracks took from capture to reception, with median and 99th percentile."""
    figure, axes = new_chart('latency', 5.0, 2.9)
    shown = latency_ms[np.isfinite(latency_ms)]
    top = float(np.percentile(shown, 99.9)) if len(shown) else 1.0
    axes.hist(np.clip(shown, 0, top), bins=60, range=(0, max(top, 1e-3)), color=ACCENT)
    for percent, dash in ((50, '-'), (99, '--')):
        if len(shown):
            value = float(np.percentile(shown, percent))
            axes.axvline(value, color=INK, linestyle=dash, linewidth=1.2)
            axes.annotate(
                f'p{percent} {value:.0f} ms',
                (value, 0.97 if percent == 50 else 0.86),
                xycoords=('data', 'axes fraction'),
                xytext=(4, 0),
                textcoords='offset points',
                va='top',
                color=INK,
            )
    axes.set_xlim(0, 1.12 * max(top, 1e-3))
    axes.set_xlabel('capture to /tracks [ms]')
    axes.set_ylabel('ticks')
    return svg_of(figure, 'Histogram of the latency')


def error_chart(line: Timeline, period_s: float) -> str:
    """Draw the mean position error over time, with the switches."""
    figure, axes = new_chart('error', 5.0, 2.9)
    seconds = line.frame * period_s
    axes.plot(seconds, line.error_m, color=ACCENT, linewidth=0.5, alpha=0.5)
    axes.plot(seconds, _smooth(line.error_m, period_s), color=ACCENT, linewidth=1.8)
    for frame in line.switch_frame:
        axes.axvline(frame * period_s, color=WARNING, linewidth=0.8, alpha=0.7)
    axes.set_ylim(bottom=0)
    axes.set_xlabel('time [s]')
    axes.set_ylabel('mean error [m]')
    return svg_of(figure, 'Position error over time')


def count_chart(line: Timeline, period_s: float) -> str:
    """Draw how many targets there were, and how many tracks."""
    figure, axes = new_chart('count', 5.0, 2.9)
    seconds = line.frame * period_s
    axes.plot(seconds, line.truth, color=INK, alpha=0.45, linewidth=2.4, label='true targets')
    axes.plot(seconds, line.tracks, color=ACCENT, linewidth=1.0, label='tracks')
    axes.plot(seconds, line.matched, color=MUTED, linewidth=0.8, label='matched')
    axes.set_ylim(bottom=0)
    axes.set_xlabel('time [s]')
    axes.set_ylabel('number')
    put_legend(axes)
    return svg_of(figure, 'Number of targets and tracks over time')


def drop_chart(seconds: Floats, late: Floats, missing: Floats, missed: Floats) -> str:
    """Draw what was late, missing and without feedback in each second."""
    figure, axes = new_chart('drops', 5.0, 2.9)
    bins = np.arange(0, max(1.0, float(np.ceil(seconds.max(initial=0.0)))) + 1)
    series = (
        ('late', late, WARNING),
        ('missing', missing, MUTED),
        ('no feedback', missed, INK),
    )
    for name, values, colour in series:
        counts, _ = np.histogram(seconds, bins, weights=values)
        axes.step(bins[:-1], counts, where='post', color=colour, linewidth=1.3, label=name)
    axes.set_ylim(0, max(1.0, axes.get_ylim()[1]))
    axes.set_xlabel('time [s]')
    axes.set_ylabel('images a second')
    put_legend(axes)
    return svg_of(figure, 'What was dropped over time')


def new_chart(name: str, width: float, height: float) -> tuple[Figure, Axes]:
    """Return a figure, inches wide and high, whose ink `svg_of` makes that of the page."""
    matplotlib.rcParams['svg.fonttype'] = 'none'
    matplotlib.rcParams['svg.hashsalt'] = name
    figure = Figure(figsize=(width, height), layout='constrained')
    axes = figure.add_subplot()
    figure.patch.set_alpha(0)
    axes.patch.set_alpha(0)
    axes.spines[['top', 'right']].set_visible(False)
    axes.spines[['left', 'bottom']].set_color(INK)
    axes.tick_params(colors=INK)
    axes.xaxis.label.set_color(INK)
    axes.yaxis.label.set_color(INK)
    axes.grid(True, color=INK, alpha=0.12, linewidth=0.7)
    axes.set_axisbelow(True)
    return figure, axes


def put_legend(axes: Axes) -> None:
    """Name the lines above the chart, where they hide nothing."""
    axes.legend(
        loc='lower left',
        bbox_to_anchor=(0, 1),
        borderaxespad=0.2,
        frameon=False,
        labelcolor=INK,
        ncols=3,
    )


def svg_of(figure: Figure, title: str) -> str:
    """Return the figure's SVG element, its ink in the colour of the page's text."""
    buffer = io.StringIO()
    metadata: dict[str, Any] = {'Date': None, 'Creator': None, 'Title': title}
    figure.savefig(buffer, format='svg', metadata=metadata)
    text = buffer.getvalue()
    text = text[text.index('<svg') :].replace(INK, 'currentColor')
    text = re.sub(r'<metadata>.*?</metadata>', '', text, flags=re.DOTALL)
    text = re.sub(
        r'<svg [^>]*?viewBox="([^"]*)"[^>]*>', r'<svg viewBox="\1" role="img">', text, count=1
    )
    text = re.sub(r' xmlns:?\w*="[^"]*"', '', text).replace('xlink:href', 'href')
    used = set(re.findall(r'#([\w.-]+)', text))  # other ids are those of every chart
    return re.sub(r' id="([^"]*)"', lambda found: found[0] if found[1] in used else '', text)


def _paths(rows: Trajectories, step: int) -> tuple[list[Floats], list[int]]:
    """Return thinned polylines, broken where a track was away, and the id of each."""
    order = np.lexsort((rows.frame, rows.id))
    order = order[rows.frame[order] % step == 0]
    frame, ids, position = rows.frame[order], rows.id[order], rows.position[order]
    apart = np.linalg.norm(np.diff(position, axis=0), axis=1)
    new = (np.diff(ids) != 0) | (np.diff(frame) > step * _PER_SECOND) | (apart > _JUMP_M)
    cuts = np.flatnonzero(new) + 1
    return np.split(position, cuts), [int(part[0]) for part in np.split(ids, cuts) if len(part)]


def _switch_places(truth: Trajectories, line: Timeline) -> Floats:
    where = {
        (frame, who): place
        for frame, who, place in zip(truth.frame.tolist(), truth.id.tolist(), truth.position)
    }
    keys = zip(line.switch_frame.tolist(), line.switch_truth_id.tolist())
    return np.array([where[key] for key in keys]).reshape(-1, 2)


def _smooth(values: Floats, period_s: float) -> Floats:
    """Return the mean over one second, gaps passed over."""
    window = np.ones(max(1, round(1.0 / period_s)))
    known = np.isfinite(values)
    total = np.convolve(np.where(known, values, 0.0), window, 'same')
    count = np.convolve(known.astype(np.float64), window, 'same')
    mean: Floats = np.divide(total, count, out=np.full(len(values), np.nan), where=count > 0)
    return mean
