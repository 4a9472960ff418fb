"""A site's coverage in numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground.coverage.coverage import Coverage

Floats = NDArray[np.float64]

LISTED = 20
"""Blind areas that are listed one by one, the largest."""
_MOST_COUNTED = 3


def coverage_figures(coverage: Coverage, site: str, command: str) -> Figures:
    """
    Return the figures of what a site's cameras see.

    Parameters
    ----------
    coverage : Coverage
        As computed.
    site, command : str
        Name of the site, and what computes the figures again.

    """
    left, right, bottom, top = coverage.raster.extent
    return Figures(
        'coverage',
        command,
        {
            'site': site,
            'area': f'{coverage.area.area:.1f} m² within x {left:.12g} to '
            f'{right:.12g}, '
            f'y {bottom:.12g} to {top:.12g} m',
            'cell_m': coverage.raster.cell,
            'error': 'standard deviation of a foot point on the ground along its worst direction,'
            ' of pixel noise and calibration',
        },
        _shares(coverage) | _blind(coverage) | _errors(coverage) | _cameras(coverage)
        | _hand_overs(coverage),
    )  # fmt: skip


def _shares(coverage: Coverage) -> dict[str, float]:
    counted = range(len(coverage.names) + 1)
    union = coverage.at_least[0].area if coverage.at_least else 0.0
    return (
        {'area_m2': coverage.area.area, 'union_m2': union}
        | {f'share.at_least_{n}': coverage.share(n) for n in range(1, _MOST_COUNTED + 1)}
        | {f'share.exactly_{n}': coverage.share_of_exactly(n) for n in counted}
    )


def _blind(coverage: Coverage) -> dict[str, float]:
    figures: dict[str, float] = {
        'blind.count': len(coverage.blind),
        'blind.m2': sum(piece.area for piece in coverage.blind),
    }
    for number, piece in enumerate(coverage.blind[:LISTED], 1):
        middle = piece.centroid
        figures |= {
            f'blind.{number}.m2': piece.area,
            f'blind.{number}.x_m': middle.x,
            f'blind.{number}.y_m': middle.y,
        }
    return figures


def _errors(coverage: Coverage) -> dict[str, float]:
    raster = coverage.raster
    return _spread('error.best', raster.best) | _spread('error.fused', raster.fused)


def _spread(name: str, error: Floats) -> dict[str, float]:
    return {
        f'{name}.median_m': _percentile(error, 50),
        f'{name}.p95_m': _percentile(error, 95),
        f'{name}.max_m': _percentile(error, 100),
    }


def _percentile(error: Floats, percent: float) -> float:
    """Return a percentile of what is not NaN; NaN if nothing is."""
    known = error[np.isfinite(error)]
    return float(np.percentile(known, percent)) if len(known) else np.nan


def _cameras(coverage: Coverage) -> dict[str, float]:
    figures: dict[str, float] = {}
    for name, field, error in zip(coverage.names, coverage.fields, coverage.raster.error):
        figures |= {
            f'camera.{name}.field_m2': field.area,
            f'camera.{name}.share': field.intersection(coverage.area).area / coverage.area.area,
            f'camera.{name}.error.median_m': _percentile(error, 50),
        }
    return figures


def _hand_overs(coverage: Coverage) -> dict[str, float]:
    figures: dict[str, float] = {}
    for hand_over in coverage.hand_overs:
        pair = 'hand_over.' + '-'.join(hand_over.cameras)
        if hand_over.zone.is_empty:
            figures[f'{pair}.gap_m'] = hand_over.gap
        else:
            figures[f'{pair}.m2'] = hand_over.zone.area
    return figures
