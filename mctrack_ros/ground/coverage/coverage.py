"""What several cameras see together: overlaps, blind areas, hand-overs, predicted errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from mctrack_ros.config import parameter
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError, Region, polygon_from
from mctrack_ros.ground.coverage.raster import Raster, raster_of
from mctrack_ros.ground.coverage.view import View

Floats = NDArray[np.float64]

_LEAST_M2 = 1e-4
"""Smaller pieces are rounding, not blind areas or overlaps."""


@dataclass(frozen=True, slots=True)
class CoverageConfig:
    """How coverage is computed."""

    cell: float = parameter(
        0.5, 'edge of a cell of the error map [m]', minimum=0.01, maximum=100.0
    )
    reach: float = parameter(
        200.0, 'range of a camera, from its foot [m]', minimum=1.0, maximum=10000.0
    )
    adjoining: float = parameter(
        1.0, 'cameras without overlap adjoin up to this gap [m]', minimum=0.0, maximum=100.0
    )


@dataclass(frozen=True, eq=False, slots=True)
class HandOver:
    """
    Where people pass from one camera to another.

    Attributes
    ----------
    cameras : (str, str)
        Names.
    zone : Polygon or MultiPolygon
        What both see; empty for cameras that only adjoin.
    gap : float
        Distance between their fields, m: 0 where they overlap.
    border : (2, 2) array
        The nearest two points of fields that only adjoin, one of each, m.

    """

    cameras: tuple[str, str]
    zone: Region
    gap: float
    border: Floats


@dataclass(frozen=True, eq=False, slots=True)
class Coverage:
    """
    What the cameras see of an area.

    Attributes
    ----------
    names : tuple of str
        Of the cameras.
    area : Polygon or MultiPolygon
        What is to be covered, m.
    fields : tuple of Polygon or MultiPolygon
        What each camera sees, beyond the area too.
    feet : (cameras, 2) array
        Where each camera stands, m; NaN where that is not known.
    at_least : tuple of Polygon or MultiPolygon
        What of the area is seen by at least 1, 2, ... cameras, as many as there are.
    blind : tuple of Polygon
        Pieces of the area that none sees, the largest first.
    hand_overs : tuple of HandOver
        Pairs of cameras that overlap within the area, or adjoin there.
    raster : Raster
        Cell by cell.

    """

    names: tuple[str, ...]
    area: Region
    fields: tuple[Region, ...]
    feet: Floats
    at_least: tuple[Region, ...]
    blind: tuple[Polygon, ...]
    hand_overs: tuple[HandOver, ...]
    raster: Raster

    def share(self, cameras: int) -> float:
        """Return the share of the area that at least so many cameras, one or more, see."""
        seen = self.at_least[cameras - 1].area if cameras <= len(self.at_least) else 0.0
        return seen / self.area.area

    def share_of_exactly(self, cameras: int) -> float:
        """Return the share of the area that exactly so many cameras, none or more, see."""
        return (1.0 if cameras == 0 else self.share(cameras)) - self.share(cameras + 1)


def coverage_of(
    views: Mapping[str, View],
    area: Region | None = None,
    config: CoverageConfig | None = None,
) -> Coverage:
    """
    Compute what cameras see of an area.

    Areas are exact, of polygons; the error map is of cells.

    Parameters
    ----------
    views : mapping of str to View
        By the camera's name.
    area : Polygon or MultiPolygon, optional
        What is to be covered, m; by default the rectangle around all that is seen.
    config : CoverageConfig, optional
        Cells, and what adjoins.

    Raises
    ------
    FieldOfViewError
        If no area is given and no camera sees any, the area is empty, or has too many cells.

    """
    config = config or CoverageConfig()
    fields = [view.field for view in views.values()]
    area = _seen_box(fields) if area is None else area
    if area.is_empty or not area.area > 0:
        raise FieldOfViewError('the area to be covered is empty')
    within = [_pieces(field.intersection(area)) for field in fields]
    at_least = _at_least(within)
    seen = at_least[0] if at_least else Polygon()
    blind = shapely.get_parts(_pieces(area.difference(seen)))
    return Coverage(
        tuple(views),
        area,
        tuple(fields),
        np.reshape([view.foot for view in views.values()], (-1, 2)),
        tuple(at_least),
        tuple(sorted(blind, key=lambda piece: -piece.area)),
        tuple(_hand_overs(list(views), within, config.adjoining)),
        raster_of(list(views.values()), area, config.cell),
    )


def area_from(text: str) -> Polygon:
    """
    Read an area from text.

    Parameters
    ----------
    text : str
        Numbers with commas between, m: ``x0,y0,x1,y1`` are two opposite corners of a rectangle,
        ``x0,y0,x1,y1,x2,y2 ...`` the corners of a polygon.

    Raises
    ------
    FieldOfViewError
        If it is none.

    """
    try:
        numbers = [float(number) for number in text.split(',')]
    except ValueError:
        numbers = []
    if len(numbers) < 4 or len(numbers) % 2:
        raise FieldOfViewError(
            f'area is {text!r}, expected x0,y0,x1,y1 or the corners x,y of a polygon, in metres'
        )
    corners = np.reshape(numbers, (-1, 2))
    if len(corners) == 2:
        (left, bottom), (right, top) = corners
        corners = np.array([[left, bottom], [right, bottom], [right, top], [left, top]])
    return polygon_from(corners, 'the area')


def _seen_box(fields: list[Region]) -> Polygon:
    seen = shapely.union_all(fields)
    if seen.is_empty:
        raise FieldOfViewError('no camera sees any ground: name an area')
    return shapely.box(*seen.bounds)


def _pieces(geometry: shapely.Geometry) -> Region:
    """Return the polygons of a geometry that are more than rounding."""
    parts = [
        part
        for part in shapely.get_parts(geometry)
        if isinstance(part, Polygon) and part.area > _LEAST_M2
    ]
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)


@np.errstate(divide='ignore', invalid='ignore')  # shapely 2.0 reports divisions inside GEOS
def _at_least(fields: list[Region]) -> list[Region]:
    """Return what at least 1, 2, ... of some regions share."""
    levels: list[Region] = []
    for field in fields:
        carried = field
        for index, level in enumerate(levels):
            levels[index] = _pieces(level.union(carried))
            carried = _pieces(level.intersection(carried))
        levels.append(carried)
    return levels


def _hand_overs(names: list[str], fields: list[Region], adjoining: float) -> list[HandOver]:
    found = []
    for first, second in combinations(range(len(names)), 2):
        one, other = fields[first], fields[second]
        if one.is_empty or other.is_empty:
            continue
        zone, gap = _pieces(one.intersection(other)), float(one.distance(other))
        if zone.is_empty and gap > adjoining:
            continue
        nearest = shapely.get_coordinates(shapely.shortest_line(one, other))
        border = nearest if zone.is_empty else np.empty((0, 2))
        found.append(HandOver((names[first], names[second]), zone, gap, border))
    return found
