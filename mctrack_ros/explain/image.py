"""An explanation as an image: the ground around the track, and what its candidates cost."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse
from numpy.typing import NDArray

from mctrack_ros.explain.costs_panel import draw_costs
from mctrack_ros.explain.history import TrackHistory
from mctrack_ros.explain.words import row_of, sentences
from mctrack_ros.interfaces import Choice, TrackStatus
from mctrack_ros.tracking.colours import track_colour

Floats = NDArray[np.floating]

CAMERA_COLOURS = ('#c1121f', '#2b6cb0', '#2b8a3e', '#e07a00', '#7b2cbf', '#0b7285', '#a61e4d')
SIGMAS = 2.0
"""Ellipses are drawn so large, in standard deviations."""
SMALLEST_M, LARGEST_M = 1.5, 5.0
"""How far from the track the image reaches, at least and at most, m."""
LIKELY = 0.01
"""A candidate of less probability need not be in the image."""
_GHOST = '#8a94a3'
_LABEL = {'boxstyle': 'round,pad=0.12', 'facecolor': 'white', 'alpha': 0.8, 'linewidth': 0}


def draw_explanation(history: TrackHistory, path: Path) -> None:
    """
    Draw the instant asked about.

    Parameters
    ----------
    history : TrackHistory
        As told.
    path : Path
        The file; its ending names the format.

    """
    figure = Figure(figsize=(12.5, 7.4), layout='constrained', dpi=110)
    ground, costs = figure.subplots(1, 2, width_ratios=(1.55, 1.0))
    said = sentences(history)
    lines = [line for one in said[:2] for line in textwrap.wrap(one, 125)]
    figure.suptitle('\n'.join(lines), x=0.01, ha='left', fontsize=11)
    _draw_ground(ground, history)
    draw_costs(costs, history, camera_colour)
    figure.legend(handles=_legend(history), loc='outside lower center', ncols=6, fontsize=9)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)


def camera_colour(index: int) -> str:
    """Return the colour of a camera."""
    return CAMERA_COLOURS[index % len(CAMERA_COLOURS)]


def _draw_ground(axes: Axes, history: TrackHistory) -> None:
    middle, reach = _window(history)
    axes.set(
        xlim=(middle[0] - reach, middle[0] + reach),
        ylim=(middle[1] - reach, middle[1] + reach),
        aspect='equal',
        xlabel='x [m]',
        ylabel='y [m]',
    )
    axes.grid(True, alpha=0.2)
    _draw_trails(axes, history)
    _draw_detections(axes, history, middle, reach)
    _draw_gates(axes, history)
    _draw_tracks(axes, history, middle, reach)


def _window(history: TrackHistory) -> tuple[Floats, float]:
    """Return the middle of what is shown, and how far it reaches, m."""
    candidates, decisions = history.now.candidates, history.now.decisions
    row = row_of(decisions, history.track_id)
    middle = decisions.position[row, :2].astype(np.float64)
    mine = candidates.track_id == decisions.track_id[row]
    mine &= candidates.choice != Choice.HIDES
    likely = mine & (candidates.probability > LIKELY)
    shown = likely if likely.any() else mine
    points = [decisions.predicted[[row]], candidates.position[shown, :2]]
    far = np.abs(np.concatenate(points) - middle).max(axis=1)
    widest = np.nanmax(np.concatenate([far, [0.0]]))
    return middle, float(np.clip(2.0 * widest, SMALLEST_M, LARGEST_M))


def _draw_trails(axes: Axes, history: TrackHistory) -> None:
    """Draw where tracks have been of late, and where this one goes."""
    for begin, end, style in ((0, history.index + 1, '-'), (history.index, None, ':')):
        paths: dict[int, list[Floats]] = {}
        for each in history.explanations[begin:end]:
            for name, place in zip(each.decisions.track_id.tolist(), each.decisions.position):
                paths.setdefault(name, []).append(place[:2])
        for name, path in paths.items():
            axes.plot(*np.array(path).T, style, color=_track_colour(name), alpha=0.45, lw=1.6)


def _draw_detections(axes: Axes, history: TrackHistory, middle: Floats, reach: float) -> None:
    """Draw every detection once, with its row, and a line to the track that took it."""
    candidates, decisions = history.now.candidates, history.now.decisions
    name = decisions.track_id[row_of(decisions, history.track_id)]
    places = dict(zip(decisions.track_id.tolist(), decisions.position[:, :2]))
    drawn = set()
    for row in range(len(candidates)):
        place, camera = candidates.position[row, :2], int(candidates.camera[row])
        colour = camera_colour(camera)
        if np.abs(place - middle).max() > reach:
            continue
        if candidates.choice[row] == Choice.TAKEN:
            own = places[int(candidates.track_id[row])]
            axes.plot(*np.stack([place, own]).T, '-', color=colour, lw=1.0, alpha=0.7)
        if candidates.track_id[row] == name:
            _draw_ellipse(axes, place, candidates.covariance[row], SIGMAS, ec=colour, alpha=0.13)
        which = camera, float(candidates.seconds[row]), int(candidates.detection[row])
        if which in drawn:
            continue
        drawn.add(which)
        symbol = 'P' if candidates.member_count[row] == 1 else 's'
        axes.plot(*place, symbol, color=colour, ms=9, mec='white', mew=0.8, zorder=4)
        axes.annotate(
            f'{which[2]}',
            tuple(place),
            (5, -10),
            textcoords='offset points',
            color=colour,
            fontsize=8,
        )


def _draw_gates(axes: Axes, history: TrackHistory) -> None:
    """Draw where each camera may show the track: the gate of its best candidate there."""
    candidates, decisions = history.now.candidates, history.now.decisions
    name = decisions.track_id[row_of(decisions, history.track_id)]
    for camera in range(len(history.cameras)):
        mine = (candidates.track_id == name) & (candidates.camera == camera)
        mine &= candidates.choice <= Choice.TAKEN
        rows = np.flatnonzero(mine)
        if len(rows):
            best = rows[int(candidates.probability[rows].argmax())]
            spread = candidates.expected_covariance[best] + candidates.covariance[best]
            colour, gate = camera_colour(camera), float(np.sqrt(history.gate))
            style = {'ec': colour, 'ls': (0, (1, 2)), 'lw': 1.6}
            _draw_ellipse(axes, candidates.expected[best], spread, gate, **style)


def _draw_tracks(axes: Axes, history: TrackHistory, middle: Floats, reach: float) -> None:
    """Draw tracks, and of the one asked about the prediction too."""
    decisions = history.now.decisions
    own = row_of(decisions, history.track_id)
    for row, name in enumerate(decisions.track_id.tolist()):
        place, colour = decisions.position[row, :2], _track_colour(name)
        if np.abs(place - middle).max() > reach:
            continue
        width = 2.4 if row == own else 1.2
        _draw_ellipse(axes, place, decisions.covariance[row], SIGMAS, ec=colour, lw=width)
        axes.plot(*place, 'o', color=colour, ms=9 if row == own else 6, mec='black', zorder=5)
        ended = decisions.status[row] == TrackStatus.DELETED
        text = f'{name}{" ended" if ended else ""}'
        axes.annotate(
            text, tuple(place), (10, 16), textcoords='offset points', fontweight='bold',
            fontsize=13 if row == own else 10, bbox=_LABEL, zorder=6,
        )  # fmt: skip
        ahead = place + 0.5 * decisions.velocity[row]
        arrow = {'arrowstyle': '->', 'color': colour, 'lw': width}
        axes.annotate('', tuple(ahead), tuple(place), arrowprops=arrow, annotation_clip=True)
    if np.isfinite(decisions.predicted[own]).all():
        place, spread = decisions.predicted[own], decisions.predicted_covariance[own]
        _draw_ellipse(axes, place, spread, SIGMAS, ec=_GHOST, lw=2.0, ls='--')
        axes.plot(*place, 'o', mfc='white', mec=_GHOST, mew=2, ms=8, zorder=4)


def _draw_ellipse(
    axes: Axes, place: Floats, covariance: Floats, sigmas: float, **style: object
) -> None:
    values, vectors = np.linalg.eigh(covariance.astype(np.float64))
    width, height = 2 * sigmas * np.sqrt(np.maximum(values, 0.0))
    angle = float(np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0])))
    fill = {'fc': style['ec'], 'fill': True} if 'alpha' in style else {'fill': False}
    axes.add_patch(Ellipse(place.tolist(), width, height, angle=angle, **style, **fill))


def _legend(history: TrackHistory) -> list[Line2D]:
    symbols = [
        Line2D([], [], color=_GHOST, ls='--', marker='o', mfc='white', label='predicted'),
        Line2D([], [], color='black', marker='o', label='track after the tick, in 0.5 s'),
        Line2D([], [], color=_GHOST, marker='P', ls='', label='detection, with its row'),
        Line2D([], [], color=_GHOST, marker='s', ls='', label='detection of several'),
        Line2D([], [], color=_GHOST, ls=':', lw=1.6, label='gate'),
        Line2D([], [], color='white', label=f'other ellipses: {SIGMAS:g} standard deviations'),
    ]
    colours = [
        Line2D([], [], color=camera_colour(index), lw=4, label=name)
        for index, name in enumerate(history.cameras)
    ]
    return symbols + colours


def _track_colour(name: int) -> str:
    return '#{:02x}{:02x}{:02x}'.format(*track_colour(name))
