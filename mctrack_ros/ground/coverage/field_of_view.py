"""Which part of the ground a camera sees, as polygons: given by its corners, or derived."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray
from shapely import MultiPolygon, Polygon
from shapely.affinity import translate

from mctrack_ros.ground.errors import CalibrationError
from mctrack_ros.ground.mapping import GroundMapping
from mctrack_ros.ground.origin import local_origin

Floats = NDArray[np.float64]
Region = Polygon | MultiPolygon
"""What a camera sees: nothing, one piece or several."""

_OUTLINE_STEP_PX = 1.0
_FARTHEST = 2.0
"""How far beyond its reach a camera's outline is followed, in reaches."""
_HALVINGS = 60
_DIRECTIONS = 720
_RADII = 400
_SMOOTHED_M = 0.001
_SLIVER_M2 = 1e-6
_FLAT = 1e-6
"""Least area of a polygon, as a share of the square over its longer extent."""


class FieldOfViewError(CalibrationError):
    """A polygon on the ground that cannot be one; says whose and why."""


def polygon_from(corners: ArrayLike, name: str = 'the polygon') -> Polygon:
    """
    Return the polygon of some corners.

    Parameters
    ----------
    corners : (k, 2) array_like
        Around it, either way, m; the first may be repeated at the end.
    name : str
        What it is, for messages.

    Raises
    ------
    FieldOfViewError
        If it has fewer than three different corners, one twice, or no area, crosses itself, or a
        number is not finite.

    """
    points = np.asarray(corners, np.float64)
    if points.ndim != 2 or points.shape[1] != 2:
        raise FieldOfViewError(f'{name} has corners of shape {points.shape}, expected (k, 2)')
    if not np.isfinite(points).all():
        raise FieldOfViewError(f'{name} has a corner that is not finite')
    distinct = len(np.unique(points, axis=0))
    if distinct < 3:
        raise FieldOfViewError(f'{name} has {distinct} different corners, expected at least 3')
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[1] <= 1e-9 * spread[0]:
        raise FieldOfViewError(f'{name} has no area: its corners lie on one line')
    polygon = Polygon(points)
    if not polygon.is_valid:
        reason = shapely.is_valid_reason(polygon)
        where = reason[reason.find('[') + 1 : reason.find(']')].split()
        raise FieldOfViewError(
            f'{name} crosses or touches itself near '
            f'({float(where[0]):.2f}, {float(where[1]):.2f}) m: '
            'its corners must go around it in order'
        )
    if distinct < len(points) - int((points[0] == points[-1]).all()):
        raise FieldOfViewError(f'{name} has a corner twice')
    if polygon.area < _FLAT * float(np.ptp(points, axis=0).max()) ** 2:
        raise FieldOfViewError(f'{name} has no area: its corners lie nearly on one line')
    return polygon


def seen_ground(
    mapping: GroundMapping,
    reach: float = 200.0,
    person_height: float = 1.75,
    least_height_px: float = 0.0,
) -> Region:
    """
    Return the ground that a camera's image shows.

    The image's outline is mapped to the ground point by point, so a lens may bend it, and cut
    where it comes near the horizon.

    Parameters
    ----------
    mapping : GroundMapping
        The camera.
    reach : float
        How far from the camera's foot it is of use, m.
    person_height : float
        Height of who is to be seen, m.
    least_height_px : float
        How high they must look, px; 0 does not limit.

    Returns
    -------
    Polygon or MultiPolygon
        Empty for a camera that sees no ground. What of the image the lens model has no
        direction for, is left out.

    """
    origin = local_origin(mapping.camera_position[:2])
    mapping = mapping.moved(-origin)
    limit = _limit(mapping, reach, person_height, least_height_px)
    shown = _shown(mapping)
    lines = _outline_on_ground(mapping, shown, _FARTHEST * reach)
    drawn = shapely.union_all([limit.exterior, *map(shapely.LineString, lines)])
    faces = shapely.get_parts(shapely.polygonize([drawn]))
    faces = faces[shapely.area(faces) > _SLIVER_M2]
    inside = shapely.point_on_surface(faces)
    pixel = mapping.image_from_ground(shapely.get_coordinates(inside))
    seen = shapely.contains_xy(shown, *pixel.T) & shapely.contains(limit, inside)
    region = shapely.union_all(faces[seen]).simplify(_SMOOTHED_M)
    region = translate(region, *origin)
    return region if isinstance(region, Polygon | MultiPolygon) else Polygon()


def _shown(mapping: GroundMapping) -> Polygon:
    """Return the image, or what of it the lens has directions for, px."""
    image, edge = shapely.box(0, 0, *mapping.image_size), mapping.lens_edge()
    shown = image.intersection(Polygon(edge)) if len(edge) else image
    return shown if isinstance(shown, Polygon) else Polygon()


def _limit(
    mapping: GroundMapping, reach: float, person_height: float, least_height_px: float
) -> Polygon:
    """Return the region around the camera's foot in which people look large enough."""
    foot = mapping.camera_position[:2]
    angle = np.linspace(0, 2 * np.pi, _DIRECTIONS, endpoint=False)
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    radius = np.full(_DIRECTIONS, reach)
    if least_height_px > 0:
        radius = _radius(mapping, direction, reach, person_height, least_height_px)
    return Polygon(foot + radius[:, None] * direction)


def _radius(
    mapping: GroundMapping, direction: Floats, reach: float, height: float, least_px: float
) -> Floats:
    """Return up to where, (n,) m, people in (n, 2) directions look large enough."""
    radius = np.geomspace(reach / 1000, reach, _RADII)
    place = mapping.camera_position[:2] + radius[:, None, None] * direction
    rows = mapping.height_px(place.reshape(-1, 2), height).reshape(_RADII, -1)
    # near the camera people are seen from above: only those beyond the tallest are too far
    fits = ~(rows < least_px)
    last = np.where(fits.any(axis=0), _RADII - 1 - fits[::-1].argmax(axis=0), 0)
    farther = np.minimum(last + 1, _RADII - 1)
    column = np.arange(len(direction))
    tall, small = rows[last, column], rows[farther, column]
    with np.errstate(invalid='ignore', divide='ignore'):
        share = np.clip((1 / least_px - 1 / tall) / (1 / small - 1 / tall), 0, 1)
    share = np.where(np.isfinite(share), share, 0.0)
    limit: Floats = radius[last] + share * (radius[farther] - radius[last])
    return limit


def _outline_on_ground(mapping: GroundMapping, shown: Polygon, farthest: float) -> list[Floats]:
    """Return an image's outline, px, as lines on the ground, each cut at a distance, m."""
    dense = shapely.segmentize(shown.exterior, _OUTLINE_STEP_PX)
    pixel = np.ascontiguousarray(shapely.get_coordinates(dense)[:-1])
    foot = mapping.camera_position[:2]
    position = mapping.ground_from_image(pixel)
    near = _is_near(position, foot, farthest)
    if near.all():
        return [np.vstack([position, position[:1]])]
    if not near.any():
        return []
    first = int(np.argmin(near))
    pixel, near = np.roll(pixel, -first, axis=0), np.roll(near, -first)
    starts = np.flatnonzero(~near[:-1] & near[1:]) + 1
    stops = np.flatnonzero(near[:-1] & ~near[1:]) + 1
    if near[-1]:
        stops = np.append(stops, len(near))
    lines = []
    for start, stop in zip(starts, stops):
        ends = [(start, start - 1), (stop - 1, stop % len(pixel))]
        edge = [_last_near(mapping, pixel[a], pixel[b], farthest) for a, b in ends]
        inner = mapping.ground_from_image(pixel[start:stop])
        lines.append(np.vstack([edge[0], inner, edge[1]]))
    return lines


def _is_near(position: Floats, foot: Floats, farthest: float) -> NDArray[np.bool_]:
    """Tell which (n, 2) positions exist and are no farther, m, from the camera's foot."""
    near: NDArray[np.bool_] = np.hypot(*(position - foot).T) <= farthest
    return near


def _last_near(mapping: GroundMapping, near: Floats, far: Floats, farthest: float) -> Floats:
    """Return the (2,) ground position at which the outline leaves the distance, m."""
    foot = mapping.camera_position[:2]
    for _ in range(_HALVINGS):
        middle = (near + far) / 2
        if _is_near(mapping.ground_from_image(middle), foot, farthest)[0]:
            near = middle
        else:
            far = middle
    place: Floats = mapping.ground_from_image(near)[0]
    return place
