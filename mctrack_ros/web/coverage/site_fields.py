"""The fields of view of a site: taken from its grid files and calibrations, written back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mctrack_ros.ground import read_grid, write_fov
from mctrack_ros.ground.coverage.coverage import CoverageConfig, area_from
from mctrack_ros.ground.coverage.field_of_view import FieldOfViewError, seen_ground
from mctrack_ros.ground.coverage.view import View
from mctrack_ros.site.coverage import camera_view
from mctrack_ros.site.site import SiteConfig
from mctrack_ros.web.coverage.fields import Corners, Fields

Floats = NDArray[np.float64]


def site_fields(site: SiteConfig, config: CoverageConfig, area: str = '') -> Fields:
    """
    Return the fields of a site's cameras, those in its grid files as drawn.

    Parameters
    ----------
    site : SiteConfig
        The cameras.
    config : CoverageConfig
        Cells, reach.
    area : str
        What is to be covered, as `area_from` reads it; empty: the site's, or all that is seen.

    Raises
    ------
    FieldOfViewError
        If the area or a field is no polygon.

    """
    drawn: dict[str, Corners] = {}
    views: dict[str, View] = {}
    for name, settings in site.cameras.items():
        view, limits = camera_view(settings, config.reach), settings.pipeline.limits
        fov = read_grid(settings.grid).fov if settings.grid else None
        if fov is not None:
            drawn[name] = tuple((x, y) for x, y in fov.tolist())
            mapping = settings.stated_mapping()
            least_px = limits.farthest_px(mapping)
            field = seen_ground(mapping, config.reach, limits.person_height_m, least_px)
            view = replace(view, field=field)
        views[name] = view
    text = area or site.area
    return Fields(views, drawn, area_from(text) if text else None, config)


def save_fields(site: SiteConfig, fields: Fields) -> str:
    """
    Write the drawn fields into the cameras' grid files; return what was done.

    Raises
    ------
    FieldOfViewError
        If a drawn field is no polygon: nothing is written then.

    """
    for flaw in fields.flaws().values():
        raise FieldOfViewError(flaw)
    without = [name for name in fields.drawn if not site.cameras[name].grid]
    written = []
    for name, settings in site.cameras.items():
        grid = read_grid(settings.grid) if settings.grid else None
        corners = fields.drawn.get(name)
        fov = None if corners is None else np.array(corners)
        if grid is not None and not _is_same(grid.fov, fov):
            write_fov(fov, settings.grid)
            written.append(name)
    lost = f'; without a grid file, so not saved: {", ".join(without)}' if without else ''
    return f'Saved into the grids of {", ".join(written) or "no camera: none changed"}{lost}'


def _is_same(one: Floats | None, other: Floats | None) -> bool:
    if one is None or other is None:
        return one is other
    return np.array_equal(one, other)
