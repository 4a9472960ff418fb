"""The default fusion tracker of a site, chosen from its calibrations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion import JointConfig, Views
from mctrack_ros.fusion.occupancy.config import OccupancyConfig, VehicleConfig
from mctrack_ros.fusion.occupancy.scene import Scene
from mctrack_ros.ground import CalibrationError
from mctrack_ros.ground.plausible import PERSON_M
from mctrack_ros.perception.event_tracker.config import EventTrackerConfig
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.site import SiteConfig

LEAST_HEIGHT_PX, LEAST_SHARE = 60.0, 0.2
"""Median height of a person over each image, and share of what is seen well that two cameras see,
from which joint occupancy is better. Terrace, four cameras (108 px, .56): MOTA .96 instead of .89;
two videos (108 px, .27): .75 instead of .65; hall (110 px, .92), at half a metre: .93 instead of
.53. Two of the pitch (31 px): -.26, joint above .7."""
MOST_DOUBT = 0.1
"""Relative deviation of how high people look, up to which masks tell people: 1 % by the
homographies of the terrace, above a tenth where a camera looks down by 80 degrees or more."""


def with_tracker(site: SiteConfig, own_detections: bool = False) -> tuple[SiteConfig, str]:
    """
    Return a site with the tracker that suits it, and why.

    With two cameras or more whose poses are known, or follow from their homographies, vehicles are
    found by the masks of all, if a camera looks for them; else joint occupancy suits those that
    see large people in a common part of the ground. Every other site keeps the joint tracker, and
    one that names its tracker that one. `mctrack run`, `mctrack track` and the launch file ask
    here; a fusion node that is started alone takes what its parameters say.

    Parameters
    ----------
    site : SiteConfig
        As it was read.
    own_detections : bool
        Whether detectors of others send detections in place of the site's camera nodes.

    """
    if site.names_tracker or type(site.fusion) is not JointConfig:
        return site, f'tracker {site.fusion.tracker}: as the site says'
    if obstacle := _obstacle(site.cameras, site.fusion, own_detections):
        return site, f'tracker joint: occupancy needs {obstacle}'
    try:
        views = site.views()
    except (ConfigError, CalibrationError):
        return site, ''  # whoever opens the cameras says what is wrong
    doubts = {name: one.height_doubt(PERSON_M) for name, one in views.mappings.items()}
    unknown = [name for name, doubt in doubts.items() if doubt > MOST_DOUBT]
    if unknown:
        return site, (
            "tracker joint: occupancy needs every camera's pose; the calibration of "
            f'{", ".join(unknown)} does not tell how high people look'
        )
    values = {each.name: getattr(site.fusion, each.name) for each in fields(JointConfig)}
    del values['tracker']
    if any(map(_seeks_vehicles, site.cameras.values())):
        why = (
            'tracker vehicles: by all masks, as pipeline.tracker.vehicles is on; '
            'fusion.tracker: joint chooses the other'
        )
        return replace(site, fusion=VehicleConfig(**values)), why
    return _by_views(site, OccupancyConfig(**values), views)


def _by_views(site: SiteConfig, fusion: OccupancyConfig, views: Views) -> tuple[SiteConfig, str]:
    """Return the site with joint occupancy where its views suit that, and why."""
    height_px = min(each.usual_height_px(PERSON_M) for each in views.mappings.values())
    share = Scene(views, site.camera_names, fusion.people).shared()
    suits = share >= LEAST_SHARE and height_px >= LEAST_HEIGHT_PX
    tracker, other = ('occupancy', 'joint') if suits else ('joint', 'occupancy')
    why = (
        f'tracker {tracker}: two cameras or more see {share:.0%} of the ground (occupancy from '
        f'{LEAST_SHARE:.0%}), people are about {height_px:.0f} px high (from '
        f'{LEAST_HEIGHT_PX:.0f}); fusion.tracker: {other} chooses the other'
    )
    return replace(site, fusion=fusion) if suits else site, why


def _obstacle(
    cameras: Mapping[str, CameraSettings], fusion: JointConfig, own_detections: bool
) -> str:
    """Return what a site lacks to be tracked by masks; empty: nothing."""
    if len(cameras) < 2:
        return 'two cameras or more'
    if own_detections:
        return 'masks, which own detections do not have'
    if fusion.untrusted:
        return 'cameras that may all start tracks, not untrusted ones'
    for name, camera in cameras.items():
        if not isinstance(camera.pipeline, EventTrackerConfig):
            return 'pipeline.local_tracker: event_tracker in every camera'
        if camera.boxes_topic:
            return f'masks, which {name} does not send, as it has a boxes_topic'
    return ''


def _seeks_vehicles(camera: CameraSettings) -> bool:
    return isinstance(camera.pipeline, EventTrackerConfig) and camera.pipeline.tracker.vehicles
