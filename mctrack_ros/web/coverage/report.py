"""What the coverage page says in words and numbers."""

from __future__ import annotations

import html

from mctrack_ros.ground.coverage.coverage import Coverage
from mctrack_ros.web.coverage.fields import Fields


def field_rows(fields: Fields) -> list[dict[str, str]]:
    """Return a row a camera: whether its field is drawn, m² and share of the area it sees."""
    coverage, drawn, flaws = fields.coverage, fields.drawn, fields.flaws()
    return [
        {
            'camera': name,
            'field': 'not yet' if name in flaws else 'drawn' if name in drawn else 'derived',
            'sees': f'{field.area:.0f}',
            'share': f'{field.intersection(coverage.area).area / coverage.area.area:.1%}',
        }
        for name, field in zip(coverage.names, coverage.fields)
    ]


def coverage_text(fields: Fields) -> str:
    """Return what is seen, by how many, and what is wrong, as HTML."""
    coverage = fields.coverage
    lines = [f'<div class="headline">{coverage.share(1):.1%} of the area is seen</div>']
    lines += [f'<div>{html.escape(line)}</div>' for line in _numbers(coverage)]
    warnings = [*fields.flaws().values(), *_blind(coverage)]
    lines += [f'<div class="warning">{html.escape(line)}</div>' for line in warnings]
    return ''.join(lines)


def _numbers(coverage: Coverage) -> list[str]:
    union = coverage.at_least[0].area if coverage.at_least else 0.0
    zones = [h for h in coverage.hand_overs if not h.zone.is_empty]
    return [
        f'Area {coverage.area.area:.0f} m², seen {union:.0f} m²',
        f'By two or more {coverage.share(2):.1%}, by three or more {coverage.share(3):.1%}',
        f'Pairs of cameras that overlap: {len(zones)}',
    ]


def _blind(coverage: Coverage) -> list[str]:
    if not coverage.blind:
        return []
    middle = coverage.blind[0].centroid
    blind = sum(piece.area for piece in coverage.blind)
    return [
        f'Blind: {blind:.0f} m², pieces: {len(coverage.blind)}, the largest about '
        f'({middle.x:.1f}, {middle.y:.1f}) m'
    ]
