"""Sites by file or by name."""

from __future__ import annotations

from pathlib import Path

from mctrack_ros.resources import config_file
from mctrack_ros.site_config import SiteConfig, load_site


def named_site(site: str) -> SiteConfig:
    """Read a site YAML, or a shipped site by its bare name, for example ``pitch5``."""
    return load_site(site_path(site))


def site_path(site: str) -> Path:
    """Return the file of a site given by path or by the bare name of a shipped one."""
    return config_file(f'{site}.yaml') if site.isidentifier() else Path(site)
