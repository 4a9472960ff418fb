"""Which tracker a site gets that names none: the one that measures best on sites like it."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import fields, replace

import numpy as np

from mctrack_ros.config import ConfigError
from mctrack_ros.fusion import JointConfig
from mctrack_ros.fusion.occupancy.config import OccupancyConfig
from mctrack_ros.fusion.occupancy.scene import Scene
from mctrack_ros.ground import CalibrationError, GroundMapping, holds_camera
from mctrack_ros.perception.event_tracker.config import EventTrackerConfig
from mctrack_ros.site.camera import CameraSettings
from mctrack_ros.site.site import SiteConfig

LEAST_HEIGHT_PX, LEAST_SHARE = 60.0, 0.2
"""Median height of a person over each image, and share of what is seen well that two cameras see,
from which joint occupancy is better. Terrace, four cameras (108 px, .56): MOTA .95 instead of .81;
two of them (108 px, .30): .72 instead of .52. Two of the pitch (31 px): -.26, joint above .7."""
PERSON_M = 1.75


def with_tracker(site: SiteConfig) -> tuple[SiteConfig, str]:
    """
    Return a site of which images are tracked with its tracker, and why it has that.

    That is `occupancy` where two cameras or more, with known poses, see people who are large
    enough, and no vehicles are looked for. Where the site names its tracker, or keeps the joint
    one, nothing is changed and nothing said.

    Parameters
    ----------
    site : SiteConfig
        As it was read.

    """
    if site.names_tracker or type(site.fusion) is not JointConfig or len(site.cameras) < 2:
        return site, ''
    if not all(map(_suits, site.cameras.values())):
        return site, ''
    values = {each.name: getattr(site.fusion, each.name) for each in fields(JointConfig)}
    del values['tracker']
    fusion = OccupancyConfig(**values)
    with suppress(ConfigError, CalibrationError):  # whoever opens the cameras says what is wrong
        views = site.views()
        height_px = min(map(_usual_height_px, views.mappings.values()))
        share = Scene(views, site.camera_names, fusion.people).shared()
        if share >= LEAST_SHARE and height_px >= LEAST_HEIGHT_PX:
            why = (
                f'tracker occupancy: two cameras or more see {share:.0%} of the ground, people '
                f'are about {height_px:.0f} px high (fusion.tracker: joint keeps the other)'
            )
            return replace(site, fusion=fusion), why
    return site, ''


def _usual_height_px(mapping: GroundMapping) -> float:
    """Return the median height of a person over an image, px."""
    position = mapping.visible_ground()
    return float(np.median(mapping.height_px(position, PERSON_M))) if len(position) else 0.0


def _suits(camera: CameraSettings) -> bool:
    """Tell whether a camera tells masks of people and its pose is known."""
    pipeline = camera.pipeline
    has_pose = camera.method == 'fitted' if camera.grid else holds_camera(camera.calibration)
    return isinstance(pipeline, EventTrackerConfig) and not pipeline.tracker.vehicles and has_pose
