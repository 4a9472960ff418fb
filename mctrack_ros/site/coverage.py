"""What the cameras of a site see of the ground."""

from __future__ import annotations

from mctrack_ros.ground import read_grid
from mctrack_ros.ground.coverage.coverage import Coverage, CoverageConfig, area_from, coverage_of
from mctrack_ros.ground.coverage.field_of_view import Region, polygon_from, seen_ground
from mctrack_ros.ground.coverage.view import View
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.site import SiteConfig


def site_coverage(
    site: SiteConfig, config: CoverageConfig | None = None, area: str = ''
) -> Coverage:
    """
    Compute what a site's cameras see, in the coordinates of its files.

    Parameters
    ----------
    site : SiteConfig
        The cameras with their calibrations.
    config : CoverageConfig, optional
        Cells, reach, what adjoins.
    area : str
        What is to be covered, as `area_from` reads it; empty: the site's, or else the rectangle
        around all that is seen.

    Raises
    ------
    FieldOfViewError
        If the area or a field of view is no polygon, or no camera sees any ground.

    """
    config = config or CoverageConfig()
    views = {name: camera_view(settings, config.reach) for name, settings in site.cameras.items()}
    text = area or site.area
    return coverage_of(views, area_from(text) if text else None, config)


def camera_view(settings: CameraSettings, reach: float = CoverageConfig().reach) -> View:
    """
    Return what one camera contributes, its noise that of its pipeline.

    Its field of view is the polygon in its grid file; where there is none it is derived.

    Parameters
    ----------
    settings : CameraSettings
        Of the camera.
    reach : float
        How far from its foot it is of use, m.

    """
    mapping = settings.stated_mapping()
    limits = settings.pipeline.limits
    given = read_grid(settings.grid).fov if settings.grid else None
    if given is not None:
        field: Region = polygon_from(given, f'{settings.grid}: the field of view')
    else:
        least_px = limits.farthest_px(mapping)
        field = seen_ground(mapping, reach, limits.person_height_m, least_px)
    return View(
        field, mapping, limits.foot_noise_px, limits.foot_noise_share, limits.person_height_m
    )
