"""The zones and lines of a site, as the map shows and saves them."""

from __future__ import annotations

from typing import Any

from mctrack_ros.site.site import SiteConfig
from mctrack_ros.zones.files import save_zones
from mctrack_ros.zones.shapes import Zones


class SiteZones:
    """
    The zones and lines in a site's file, in the positions of `/tracks`.

    Parameters
    ----------
    site : SiteConfig
        Read from a file.

    """

    def __init__(self, site: SiteConfig) -> None:
        self._path, self._origin = site.path, site.origin
        self._zones = site.own_zones

    def described(self) -> list[dict[str, Any]]:
        """Return them as the browser takes them."""
        return self._zones.described()

    def save(self, zones: Zones) -> str:
        """
        Write others in their place; return what was done.

        Raises
        ------
        ConfigError
            If one of them is wrong, or the file cannot be written: then nothing changes.

        """
        save_zones(self._path, zones.moved(self._origin))
        self._zones = zones
        return f'Saved {len(zones)} in {self._path}: they count when the site is started again'
