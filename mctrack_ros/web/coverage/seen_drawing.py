"""What the coverage page draws over the image of the chosen camera."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from mctrack_ros.ground import GroundMapping
from mctrack_ros.web.coverage.drawing import COLOURS
from mctrack_ros.web.coverage.fields import Fields
from mctrack_ros.web.coverage.seen_field import mapping_of, seen_corners
from mctrack_ros.web.drawing import Drawing, Line, Mark
from mctrack_ros.web.lines import SAMPLES, Extent, cut, metre_grid

Floats = NDArray[np.float64]
_STEP_M = 0.5
"""How far apart outlines on the ground are sampled, m."""


def seen_drawing(fields: Fields) -> Drawing:
    """
    Return what lies over the chosen camera's image, px.

    A metre grid over the area, how far the camera is of use, all cameras' fields, what of the
    blind areas it could see, and the corners of its own field.
    """
    mapping, coverage = mapping_of(fields), fields.coverage
    grid = metre_grid(np.reshape(coverage.area.bounds, (2, 2)))
    lines = _lines(mapping, grid, 'metres')
    blind = shapely.intersection(shapely.union_all(list(coverage.blind)), fields.view.field)
    lines += _lines(mapping, _outlines(blind), 'blind')
    lines += _lines(mapping, [_far(mapping, fields.reach)], 'reach')
    for index, (name, field) in enumerate(zip(coverage.names, coverage.fields)):
        kind = f'field camera{index % COLOURS}' + (' current' if name == fields.chosen else '')
        lines += _lines(mapping, _outlines(field), kind)
    marks = [
        Mark(str(i), x, y, 'chosen' if i == fields.corner else 'corner', movable=True)
        for i, (x, y) in enumerate(seen_corners(fields).tolist())
        if np.isfinite([x, y]).all()
    ]
    return Drawing(lines, [], marks)


def image_extent(mapping: GroundMapping) -> Extent:
    """Return left, top, width and height of a camera's image, px."""
    width, height = mapping.image_size
    return (0.0, 0.0, float(width), float(height))


def _lines(mapping: GroundMapping, lines: list[Floats], kind: str) -> list[Line]:
    pieces = cut(lines, mapping.image_from_ground, image_extent(mapping))
    return [Line(piece, kind) for piece in pieces]


def _outlines(region: shapely.Geometry) -> list[Floats]:
    """Return (n, 2) points along each outline of a region, m."""
    rings = [
        ring
        for polygon in shapely.get_parts(region)
        if isinstance(polygon, shapely.Polygon) and not polygon.is_empty
        for ring in (polygon.exterior, *polygon.interiors)
    ]
    return [shapely.get_coordinates(shapely.segmentize(ring, _STEP_M)) for ring in rings]


def _far(mapping: GroundMapping, reach: float) -> Floats:
    """Return (n, 2) points at the reach around the camera's foot, m."""
    angle = np.linspace(0, 2 * np.pi, 12 * SAMPLES)
    circle: Floats = mapping.camera_position[:2] + reach * np.column_stack(
        [np.cos(angle), np.sin(angle)]
    )
    return circle
