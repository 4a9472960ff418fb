"""A site's cameras over video files."""

from __future__ import annotations

from collections.abc import Mapping

from mctrack_ros.recording.video.videos import Video, together
from mctrack_ros.replay.camera_source import CameraTask
from mctrack_ros.replay.lockstep import ReplayError, tick_ns
from mctrack_ros.site.site import SiteConfig


def video_tasks(videos: Mapping[str, Video], site: SiteConfig) -> list[CameraTask]:
    """
    Return the tasks of a site's cameras over their videos.

    Raises
    ------
    ReplayError
        If the videos are not those of the site's cameras, or have another size.

    """
    period_ns, delay_ns = tick_ns(site)
    for name in sorted(videos.keys() - site.cameras.keys()):
        raise ReplayError(
            f'the site {site.name} has no camera {name}, only {", ".join(site.cameras)}'
        )
    for name, settings in site.cameras.items():
        if name not in videos:
            raise ReplayError(
                f'no video of camera {name} of the site {site.name}: give {name}=FILE'
            )
        size, wanted = videos[name].size, (settings.image_width, settings.image_height)
        if size != wanted:
            raise ReplayError(
                f'{videos[name].path} holds images of {size[0]} x {size[1]} px, but {name} of '
                f'the site {site.name} takes {wanted[0]} x {wanted[1]}: set image_width and '
                'image_height of the camera, and calibrate for that size'
            )
    sources = together(videos)
    return [
        CameraTask(videos[name].path, name, settings, period_ns, delay_ns, video=sources[name])
        for name, settings in site.cameras.items()
    ]
