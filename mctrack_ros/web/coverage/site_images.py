"""An image of each camera of a site, from where the command line says."""

from __future__ import annotations

from collections.abc import Sequence

from mctrack_ros.recording import is_bag
from mctrack_ros.site.names import named_image_topic, resolved
from mctrack_ros.site.site import SiteConfig
from mctrack_ros.web.image_source import LIVE, Image, ImageError, read_image


def site_images(site: SiteConfig, sources: Sequence[str]) -> dict[str, Image]:
    """
    Read an image of each camera for which a source is named.

    Parameters
    ----------
    site : SiteConfig
        The cameras, their topics and the size of their images.
    sources : sequence of str
        ``camera=source``, with a source as `read_image` takes it; or a bag or ``live`` alone,
        for all cameras that are not named.

    Returns
    -------
    dict of str to (height, width, 3) uint8 array
        By the name of the camera.

    Raises
    ------
    ImageError, BagError
        If an image cannot be had, or has another size than the site says.

    """
    named: dict[str, str] = {}
    for text in sources:
        name, equals, source = text.partition('=')
        if equals and name not in site.cameras:
            known = ', '.join(site.cameras)
            raise ImageError(f'--source {text}: expected one of the cameras {known}')
        if not equals and not (text == LIVE or is_bag(text)):
            raise ImageError(
                f'--source {text} is no bag: name its camera, for example '
                f'{site.camera_names[0]}={text}'
            )
        for camera in (name,) if equals else site.cameras.keys() - named.keys():
            named[camera] = source if equals else text
    return {name: _image(site, name, source) for name, source in sorted(named.items())}


def _image(site: SiteConfig, camera: str, source: str) -> Image:
    settings = site.cameras[camera]
    topic = resolved(named_image_topic(camera, settings.image_topic))
    image = read_image(source, camera, topic if source == LIVE or is_bag(source) else '')
    height, width = image.shape[:2]
    if (width, height) != (settings.image_width, settings.image_height):
        raise ImageError(
            f'{source}: the image of {camera} has {width} x {height} px, the site says '
            f'{settings.image_width} x {settings.image_height}'
        )
    return image
