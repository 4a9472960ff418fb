"""A picture of each camera of a site, from where the command line says."""

from __future__ import annotations

from collections.abc import Sequence

from mctrack_ros.recording import is_bag
from mctrack_ros.site.names import picture_topic, resolved
from mctrack_ros.site.site import SiteConfig
from mctrack_ros.web.picture_source import LIVE, Image, PictureError, read_picture


def site_pictures(site: SiteConfig, sources: Sequence[str]) -> dict[str, Image]:
    """
    Read a picture of each camera for which a source is named.

    Parameters
    ----------
    site : SiteConfig
        The cameras, their topics and the size of their pictures.
    sources : sequence of str
        ``camera=source``, with a source as `read_picture` takes it; or a bag or ``live`` alone,
        for all cameras that are not named.

    Returns
    -------
    dict of str to (height, width, 3) uint8 array
        By the name of the camera.

    Raises
    ------
    PictureError, BagError
        If a picture cannot be had, or has another size than the site says.

    """
    named: dict[str, str] = {}
    for text in sources:
        name, equals, source = text.partition('=')
        if equals and name not in site.cameras:
            known = ', '.join(site.cameras)
            raise PictureError(f'--source {text}: expected one of the cameras {known}')
        if not equals and not (text == LIVE or is_bag(text)):
            raise PictureError(
                f'--source {text} is no bag: name its camera, for example '
                f'{site.camera_names[0]}={text}'
            )
        for camera in (name,) if equals else site.cameras.keys() - named.keys():
            named[camera] = source if equals else text
    return {name: _picture(site, name, source) for name, source in sorted(named.items())}


def _picture(site: SiteConfig, camera: str, source: str) -> Image:
    settings = site.cameras[camera]
    topic = resolved(picture_topic(camera, settings.image_topic))
    picture = read_picture(source, camera, topic if source == LIVE or is_bag(source) else '')
    height, width = picture.shape[:2]
    if (width, height) != (settings.image_width, settings.image_height):
        raise PictureError(
            f'{source}: the picture of {camera} has {width} x {height} px, the site says '
            f'{settings.image_width} x {settings.image_height}'
        )
    return picture
