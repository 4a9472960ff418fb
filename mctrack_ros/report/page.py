"""The report: one HTML page that needs nothing beside it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from mctrack_ros.evaluation import Timeline, Trajectories, ground_timeline
from mctrack_ros.evaluation.comparison import Comparison
from mctrack_ros.evaluation.figures import Figures, text_of
from mctrack_ros.report import charts
from mctrack_ros.report.dropped import COUNTS, Drops, drops_of
from mctrack_ros.report.ground_plan import hex_colour, pitch_lines
from mctrack_ros.report.images import camera_images
from mctrack_ros.report.session import Session
from mctrack_ros.report.strips import encounter_strips
from mctrack_ros.report.targets import DEMO_TARGETS, Target
from mctrack_ros.simulation import LENGTH_M, WIDTH_M

_PER_SECOND = 5


@dataclass(frozen=True, slots=True)
class FigureRow:
    """A figure beside its target: name, label, text, the target's text, whether it is met."""

    name: str
    label: str
    text: str
    target: str
    met: bool | None


def write_report(
    path: str | Path,
    session: Session,
    figures: Figures,
    gate_m: float,
    settings: Mapping[str, Any],
) -> None:
    """
    Write the page.

    Parameters
    ----------
    path : str or Path
        The HTML file.
    session : Session
        What was tracked.
    figures : Figures
        What it scored.
    gate_m : float
        Gate of the comparison with truth, m.
    settings : mapping
        What the site was set to, nested.

    """
    truth, tracks = session.trajectories()
    line = ground_timeline(truth, tracks, gate_m)
    drops = drops_of(session.ticks, session.start_ns, len(session.cameras))
    middle = session.start_ns + int(session.duration_s * 5e8) // session.period_ns * (
        session.period_ns
    )
    period_s = session.period_ns * 1e-9
    headline, others = _figure_rows(figures)
    text = template('report.html.j2').render(
        figures=figures,
        headline=headline,
        others=others,
        charts=_charts(session, truth, tracks, line, drops),
        replay=_json(replay_data(truth, tracks, line, period_s)),
        images=camera_images(session, middle + session.period_ns // 2),
        image_time=f'{session.seconds(middle):.1f}',
        strips=encounter_strips(session),
        dropped=_dropped_table(session, drops),
        switches=len(line.switch_frame),
        switch_lines=_switch_lines(session, truth, tracks, gate_m),
        site=json.dumps(session.site, indent=2, sort_keys=True),
        settings=json.dumps(settings, indent=2),
    )
    Path(path).write_text(text, encoding='utf-8')


def template(name: str, **filters: Callable[[Any], str]) -> Any:
    """Return a template of pages, with filters of its own; what it shows is escaped."""
    loader = PackageLoader('mctrack_ros.report', 'templates')
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    environment.filters |= filters
    return environment.get_template(name)


def _charts(
    session: Session, truth: Trajectories, tracks: Trajectories, line: Timeline, drops: Drops
) -> dict[str, str]:
    """Return the page's SVG by name; without latencies, as offline, there is no such chart."""
    period_s = session.period_ns * 1e-9
    latency = session.latency_ms()
    made = {
        'trajectories': charts.trajectory_chart(truth, tracks, line, period_s),
        'error': charts.error_chart(line, period_s),
        'count': charts.count_chart(line, period_s),
        'drops': charts.drop_chart(
            drops.seconds,
            *(drops.counts[name].sum(axis=1) for name in ('late', 'missing', 'feedback_missed')),
        ),
    }
    if np.any(latency):
        made['latency'] = charts.latency_chart(latency)
    return made


def _switch_lines(
    session: Session, truth: Trajectories, tracks: Trajectories, gate_m: float
) -> list[str]:
    """Return what to say of the identity switches, and how to ask why."""
    first_ns = session.tracks[0].stamp_ns if session.tracks else 0
    first = (first_ns - session.start_ns) // session.period_ns
    comparison = Comparison(
        session.source,
        session.recorded,
        truth,
        tracks,
        -first * session.period_ns,
        session.period_ns,
    )
    return comparison.switch_lines(gate_m)


def _figure_rows(figures: Figures) -> tuple[list[FigureRow], list[FigureRow]]:
    """Return the figures that have an entry among the targets, in its order, and the others."""
    known = {
        target.figure: target
        for target in DEMO_TARGETS
        if target.experiment == figures.name and target.figure in figures.figures
    }
    headline = [_figure_row(name, figures.figures[name], target) for name, target in known.items()]
    others = [
        _figure_row(name, value, None)
        for name, value in figures.figures.items()
        if name not in known
    ]
    return headline, others


def _figure_row(name: str, value: float, target: Target | None) -> FigureRow:
    label = name.replace('_', ' ') if target is None else target.label
    met = None if target is None or not np.isfinite(value) else target.is_met(value)
    return FigureRow(name, label, text_of(value), '' if target is None else target.text, met)


def _dropped_table(session: Session, drops: Drops) -> list[tuple[str, list[int]]]:
    """Return each camera's counts over the whole run, in the order of ``COUNTS``."""
    sums = np.stack([drops.per_camera(name) for name in COUNTS], axis=1)
    rows = list(zip(session.cameras, sums.tolist()))
    return [*rows, ('all', sums.sum(axis=0).tolist())]


def _json(value: Any) -> str:
    """Return JSON that may stand in a script element."""
    text = json.dumps(value, separators=(',', ':'))
    return text.replace('<', '\\u003c').replace('>', '\\u003e').replace('&', '\\u0026')


def replay_data(
    truth: Trajectories, tracks: Trajectories, line: Timeline, period_s: float
) -> dict[str, Any]:
    """
    Return what the page's script draws, ready for JSON; positions in whole centimetres.

    Parameters
    ----------
    truth, tracks : Trajectories
        In frames of one period.
    line : Timeline
        For the switches.
    period_s : float
        Period of the frames, s.

    """
    step = max(1, round(1.0 / _PER_SECOND / period_s))
    last = int(max(truth.frame.max(initial=0), tracks.frame.max(initial=0)))
    return {
        'size': [LENGTH_M, WIDTH_M],
        'lines': [np.round(polyline, 2).tolist() for polyline in pitch_lines()],
        'seconds_a_step': step * period_s,
        'steps': last // step + 1,
        'truth': _by_id(truth, step),
        'tracks': _by_id(tracks, step),
        'colours': {int(who): hex_colour(int(who)) for who in np.unique(tracks.id)},
        'switches': np.stack([line.switch_frame / step, line.switch_truth_id], axis=1).tolist(),
    }


def _by_id(rows: Trajectories, step: int) -> dict[int, list[list[int]]]:
    """Return id -> [step, x, y] ..., the time thinned to whole steps."""
    kept = rows.select(rows.frame % step == 0)
    order = np.lexsort((kept.frame, kept.id))
    table = np.column_stack([kept.frame // step, np.round(kept.position * 100)]).astype(int)
    ids, starts = np.unique(kept.id[order], return_index=True)
    parts = np.split(table[order], starts[1:])
    return {who: part.tolist() for who, part in zip(ids.tolist(), parts)}
