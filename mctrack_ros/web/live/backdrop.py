"""What lies under the tracks: the site as the browser draws it, in the positions of `/tracks`."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np
import shapely
import shapely.affinity

from mctrack_ros.ground import CalibrationError
from mctrack_ros.ground.coverage.coverage import area_from
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError, Region
from mctrack_ros.report.ground_plan import pitch_lines
from mctrack_ros.site.coverage import camera_view
from mctrack_ros.site.site import SiteConfig

PLAN = '/plan'
"""Address of the floor plan."""
_AROUND = 0.12
"""How far beyond the area fields of view are drawn, in its diagonals."""
_FINE_M = 0.05
"""Outlines are drawn to this."""


def backdrop(site: SiteConfig) -> dict[str, Any]:
    """
    Return the site as the browser takes it.

    ``name``; ``bounds`` (left, low, right, high, m) of what is shown at first; ``area``, outlines;
    ``lines`` of a pitch; ``plan``, address and corners of a floor plan, or None; ``cameras``, each
    with ``name``, ``foot`` (x, y) or None, and ``field``, outlines.
    """
    fields: dict[str, Region] = {}
    feet: dict[str, list[float] | None] = {}
    for name, settings in site.cameras.items():
        fields[name], feet[name] = shapely.Polygon(), None
        with suppress(CalibrationError, FieldOfViewError):  # the camera's node says why
            view = camera_view(settings)
            fields[name] = _moved(view.field, site)
            foot = view.foot - site.origin
            feet[name] = foot.tolist() if np.isfinite(foot).all() else None
    corners = _corners(site)
    parts = [_moved(area_from(site.area), site)] if site.area else list(fields.values())
    extent = shapely.union_all(parts + ([shapely.box(*corners)] if corners else []))
    bounds = None if extent.is_empty else list(extent.bounds)
    around = 0.0 if bounds is None else _AROUND * math.dist(bounds[:2], bounds[2:])
    shown = extent.buffer(around)
    return {
        'name': site.name,
        'bounds': bounds,
        'area': _outlines(parts[0]) if site.area else [],
        'lines': [(line - site.origin).tolist() for line in pitch_lines()]
        if site.is_pitch
        else [],
        'plan': {'address': PLAN, 'corners': corners} if corners else None,
        'cameras': [
            {
                'name': name,
                'foot': feet[name],
                'field': _outlines(fields[name].intersection(shown)),
            }
            for name in site.cameras
        ],
    }


def no_backdrop(name: str) -> dict[str, Any]:
    """Return the same of a site of which only tracks are known."""
    nothing: dict[str, Any] = {'area': [], 'lines': [], 'plan': None, 'cameras': []}
    return {'name': name, 'bounds': None, **nothing}


def _corners(site: SiteConfig) -> tuple[float, float, float, float] | None:
    """Return left, low, right and high edge of the floor plan, m."""
    if site.floor_plan is None:
        return None
    (left, low, right, high), (x, y) = site.floor_plan.corners, site.origin
    return left - x, low - y, right - x, high - y


def _moved(region: Region, site: SiteConfig) -> Region:
    return shapely.affinity.translate(region, *np.negative(site.origin))


def _outlines(region: shapely.Geometry) -> list[list[list[float]]]:
    """Return the rings of a region, m."""
    rings = []
    for polygon in shapely.get_parts(shapely.simplify(region, _FINE_M)):
        if isinstance(polygon, shapely.Polygon):
            for ring in (polygon.exterior, *polygon.interiors):
                rings.append(shapely.get_coordinates(ring).round(3).tolist())
    return rings
