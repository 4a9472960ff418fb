"""What the coverage page draws: fields, blind areas, maps of counts and errors."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from matplotlib import colormaps
from numpy.typing import NDArray

from mctrack_ros.ground.coverage.coverage import Coverage
from mctrack_ros.web.coverage.fields import Fields
from mctrack_ros.web.drawing import Drawing, Line, Mark
from mctrack_ros.web.lines import Extent

Floats = NDArray[np.float64]
MAPS = {'cameras': 'cameras', 'best': 'best error', 'fused': 'fused error'}
MARGIN = 0.08
NEAR = 0.5
"""How far outside the area, in its diagonals, a camera may stand and still be shown."""
COLOURS = 8


@dataclass(frozen=True, eq=False, slots=True)
class Map:
    """
    An image of the area, a pixel a cell, and what its colours mean.

    Attributes
    ----------
    png : bytes
        The image, north up.
    frame : (float, float, float, float)
        Left, top (-y), width and height of the image, m.
    least, most : str
        What its first and its last colour stand for.

    """

    png: bytes
    frame: Extent
    least: str
    most: str


def fields_drawing(fields: Fields) -> Drawing:
    """Return the fields of view, the blind areas and the chosen camera's corners, y upwards."""
    coverage = fields.coverage
    lines = [Line(ring, 'blind') for piece in coverage.blind for ring in _rings(piece)]
    lines += [Line(ring, 'area') for ring in _rings(coverage.area)]
    for index, (name, field) in enumerate(zip(coverage.names, coverage.fields)):
        kind = f'field camera{index % COLOURS}' + (' current' if name == fields.chosen else '')
        lines += [Line(ring, kind) for ring in _rings(field)]
    marks = [
        Mark(name, x, -y, f'foot camera{index % COLOURS}')
        for index, (name, (x, y)) in enumerate(zip(coverage.names, coverage.feet.tolist()))
        if np.isfinite([x, y]).all()
    ]
    corners = fields.drawn.get(fields.chosen, ())
    marks += [
        Mark(str(i), x, -y, 'chosen' if i == fields.corner else 'corner', movable=True)
        for i, (x, y) in enumerate(corners)
    ]
    return Drawing(lines, [], marks)


def fields_extent(coverage: Coverage) -> Extent:
    """Return left, top (-y), width and height of the plan, m: the area and cameras near it."""
    bounds = np.reshape(coverage.area.bounds, (2, 2))
    diagonal = float(np.linalg.norm(bounds[1] - bounds[0]))
    away = [coverage.area.distance(shapely.Point(foot)) for foot in coverage.feet]
    shown = np.vstack([bounds, coverage.feet[np.array(away) < NEAR * diagonal]])
    (left, bottom), (right, top) = shown.min(axis=0).tolist(), shown.max(axis=0).tolist()
    margin = MARGIN * max(right - left, top - bottom)
    return (left - margin, -top - margin, right - left + 2 * margin, top - bottom + 2 * margin)


def coverage_map(coverage: Coverage, kind: str) -> Map:
    """Return one of `MAPS`: how many cameras see each cell, or the predicted error, m."""
    raster = coverage.raster
    if kind == 'cameras':
        most = max(int(raster.count.max(initial=0)), 1)
        shade = np.where(raster.inside & (raster.count > 0), raster.count / most, np.nan)
        least_text, most_text = '0', f'{most} cameras'
        colours = colormaps['Blues'](0.15 + 0.75 * shade)
    else:
        error = raster.best if kind == 'best' else raster.fused
        known = error[np.isfinite(error)]
        low, high = (known.min(), known.max()) if len(known) else (0.1, 1.0)
        shade = np.log(error / low) / max(np.log(high / low), 1e-9)
        least_text, most_text = f'{low:.2g} m', f'{high:.2g} m'
        colours = colormaps['viridis_r'](shade)
    colours[..., 3] = np.where(np.isfinite(shade), 0.85, 0.0)
    bgra = np.round(255 * colours[::-1, :, [2, 1, 0, 3]]).astype(np.uint8)
    left, right, bottom, top = raster.extent
    frame = (left, -top, right - left, top - bottom)
    return Map(cv2.imencode('.png', bgra)[1].tobytes(), frame, least_text, most_text)


def _rings(region: shapely.Geometry) -> list[list[list[float]]]:
    """Return the outlines of a region, y downwards."""
    rings = []
    for polygon in shapely.get_parts(region):
        for ring in (polygon.exterior, *polygon.interiors):
            flipped = shapely.get_coordinates(ring) * np.array([1.0, -1.0])
            rings.append(flipped.tolist())
    return rings
