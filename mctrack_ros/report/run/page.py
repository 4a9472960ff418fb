"""The report of a run: one HTML page that needs nothing beside it, and the same as PDF."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_ros import __version__
from mctrack_ros.report.coverage_figures import coverage_figures
from mctrack_ros.report.ground_plan import hex_colour
from mctrack_ros.report.page import template
from mctrack_ros.report.run import charts
from mctrack_ros.report.run.clock import clock
from mctrack_ros.report.run.data import RunData, TrackData

_TRACKS, _MAPS, _ROWS, _GAPS = 40, 12, 20, 5
"""Most tracks, heat maps, rows of other tables, and gaps that are shown."""


class ReportError(ValueError):
    """A report that cannot be made; says what is missing."""


def write_run_report(data: RunData, files: Sequence[Path], command: str) -> None:
    """
    Write the report of a run.

    Parameters
    ----------
    data : RunData
        What is told.
    files : sequence of Path
        Where: names that end in ``.html`` or ``.pdf``.
    command : str
        What makes it again.

    Raises
    ------
    ReportError
        If a PDF is wanted and WeasyPrint or a library of it is not installed.

    """
    text = run_page(data, command)
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        if file.suffix.lower() == '.pdf':
            _write_pdf(text, file)
        else:
            file.write_text(text, encoding='utf-8')


def run_page(data: RunData, command: str) -> str:
    """Return the page; parameters as in `write_run_report`."""
    longest = data.tracks[:_TRACKS]
    ground = charts.Ground(data)
    by_length = sorted(data.groups, key=lambda each: each.began_s - each.ended_s)
    made = {'count': charts.count_chart(data), 'heat': charts.heat_chart(data, ground)}
    made['presence'] = charts.presence_chart(longest, data.between)
    made['events'] = charts.event_chart(data)
    if data.coverage:
        made['coverage'] = charts.coverage_image(data.coverage)
    return str(
        template('run.html.j2', clock=clock, css=_css).render(
            data=data,
            subtitle=_subtitle(data),
            headline=_headline(data),
            charts=made,
            tracks=_track_rows(longest),
            shorter=_shorter(data.tracks[_TRACKS:]),
            maps=[
                (track.summary.track_id, charts.track_heat_chart(track, ground))
                for track in data.tracks[:_MAPS]
            ],
            corrections=data.corrections[:_ROWS],
            groups=sorted(by_length[:_ROWS], key=lambda each: each.began_s),
            quality=_quality(data),
            troubles=data.quality.troubles[:_ROWS],
            coverage=_coverage(data),
            made=_made(data, command),
        )
    )


def _subtitle(data: RunData) -> str:
    first, last = data.between
    when = f'{clock(first)} to {clock(last)} of a run'
    return f'{when} that began at {data.began}' if data.began else when


def _headline(data: RunData) -> list[tuple[str, str]]:
    distance = sum(track.summary.distance_m for track in data.tracks)
    present = data.present
    fastest = max((track.summary.top_mps for track in data.tracks), default=0.0)
    return [
        ('tracks', str(len(data.tracks))),
        ('at once, on average', f'{present.mean():.1f}' if len(present) else '0'),
        ('at once, at most', str(present.max(initial=0))),
        ('tracked altogether', clock(sum(track.seconds for track in data.tracks), 0)),
        ('walked altogether', _metres(distance)),
        ('top speed', f'{fastest:.1f} m/s'),
        ('identities corrected', str(len(data.corrections))),
        ('ticks missing', str(data.quality.missing)),
    ]


def _track_rows(tracks: Sequence[TrackData]) -> list[dict[str, Any]]:
    farthest = max((track.summary.distance_m for track in tracks), default=0.0) or 1.0
    return [
        {
            'id': track.summary.track_id,
            'colour': hex_colour(track.summary.track_id),
            'class_name': track.summary.class_name,
            'began': clock(track.summary.began_s),
            'ended': clock(track.summary.ended_s),
            'seconds': clock(track.seconds),
            'distance': f'{track.summary.distance_m:.0f}',
            'share': round(100 * track.summary.distance_m / farthest),
            'mean': f'{track.summary.mean_mps:.2f}',
            'top': f'{track.summary.top_mps:.2f}',
        }
        for track in tracks
    ]


def _shorter(tracks: Sequence[TrackData]) -> str:
    """Return a sentence on the tracks that are not listed; empty: all are."""
    if not tracks:
        return ''
    seconds = [track.seconds for track in tracks]
    metres = _metres(sum(track.summary.distance_m for track in tracks))
    return (
        f'{len(tracks)} shorter ones are not listed: {clock(min(seconds))} to '
        f'{clock(max(seconds))} long, {metres} altogether.'
    )


def _quality(data: RunData) -> list[tuple[str, str]]:
    quality = data.quality
    rate = f', {1 / quality.interval_s:.4g} a second' if quality.interval_s else ''
    told = [('ticks', f'{quality.ticks}{rate}'), ('missing in between', str(quality.missing))]
    if quality.gaps:
        shown = [f'{clock(first)} to {clock(last)}' for first, last in quality.gaps[:_GAPS]]
        rest = len(quality.gaps) - len(shown)
        told.append(('longest gaps', ', '.join(shown) + (f' and {rest} more' if rest else '')))
    nobody = float((data.present == 0).mean()) if len(data.present) else 1.0
    told.append(('ticks without a track', f'{100 * nobody:.1f} %'))
    if len(quality.error_m):
        median, most = quality.error_m.tolist()
        told.append(
            (
                'stated error of positions',
                f'{median:.2f} m (median), {most:.2f} m (95th percentile), 1 sigma',
            )
        )
    returns = [max(len(track.spells) - 1, 0) for track in data.tracks]
    told.append(
        ('tracks that were away for more than a second', str(int(np.count_nonzero(returns))))
    )
    return told


def _coverage(data: RunData) -> list[tuple[str, str]]:
    """Return the figures of the site's coverage that matter here."""
    if not data.coverage:
        return []
    figures = coverage_figures(data.coverage, data.site, '').figures
    return [
        ('area', f'{figures["area_m2"]:.0f} m²'),
        ('seen by a camera', f'{100 * figures["share.at_least_1"]:.1f} %'),
        ('seen by two or more', f'{100 * figures["share.at_least_2"]:.1f} %'),
        ('blind', f'{figures["blind.m2"]:.0f} m² in {figures["blind.count"]:.0f} places'),
        (
            'predicted error, all cameras',
            f'{figures["error.fused.median_m"]:.2f} m, at most '
            f'{figures["error.fused.max_m"]:.2f} m (1 sigma, worst direction)',
        ),
    ]


def _made(data: RunData, command: str) -> list[tuple[str, str]]:
    return [
        ('command', command),
        ('run', data.run),
        ('site', data.site),
        ('distance', 'over steps of 0.2 s; pauses of more than a second do not count'),
        ('top speed', 'the fastest step of 0.2 s'),
        ('version', f'mctrack_ros {__version__}'),
    ]


def _metres(distance: float) -> str:
    return f'{distance / 1000:.1f} km' if distance >= 1000 else f'{distance:.0f} m'


def _write_pdf(text: str, file: Path) -> None:
    try:
        from weasyprint import HTML
    except (ImportError, OSError) as error:  # OSError: a library of Pango is not there
        reason = str(error).splitlines()[0]
        raise ReportError(
            f'{file} needs WeasyPrint (pip install weasyprint) and Pango (apt install '
            f'libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0): {reason}'
        ) from error
    HTML(string=text).write_pdf(file)


def _css(text: str) -> str:
    """Return text as it may stand in a string of a style sheet in a page."""
    plain = ' .,_-'
    return ''.join(
        each if each.isalnum() or each in plain else f'\\{ord(each):x} ' for each in text
    )
