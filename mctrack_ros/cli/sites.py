"""Sites by file or by name."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from mctrack_ros.config import ConfigError
from mctrack_ros.ground.yaml_files import read_yaml_file
from mctrack_ros.resources import config_file, share_directory
from mctrack_ros.site.site import SiteConfig, load_site


def named_site(site: str) -> SiteConfig:
    """Read a site YAML, or a shipped site by its bare name, for example ``pitch5``."""
    return load_site(site_path(site))


def optional_site(site: str) -> SiteConfig | None:
    """Read a site as `named_site` does; None: none is named."""
    return named_site(site) if site else None


def camera_site(site: str) -> SiteConfig:
    """
    Read a site that has cameras.

    Raises
    ------
    ConfigError
        If it has cells instead.

    """
    config = named_site(site)
    if config.cells:
        raise ConfigError(
            f'the site {config.name} has cells, no cameras: take the site of one of them '
            f'({", ".join(config.cells)})'
        )
    return config


def calibration_doubts(site: SiteConfig) -> Iterator[str]:
    """Yield a line on each calibration file that states what is left out; absent files pass."""
    for name, camera in site.cameras.items():
        doubt = camera.doubt() if Path(camera.calibration).is_file() else ''
        if doubt:
            yield f'{name}: {camera.calibration}: {doubt}'


def site_path(site: str) -> Path:
    """
    Return the file of a site given by path or by the bare name of a shipped one.

    Raises
    ------
    ConfigError
        If no site of that name is shipped; says which are.

    """
    if not site.isidentifier():
        return Path(site)
    path = config_file(f'{site}.yaml')
    if not path.is_file():
        raise ConfigError(
            f'no site {site!r} is shipped, only {", ".join(shipped_sites())}; one of your own '
            f'is given by its file, for example {site}.yaml'
        )
    return path


def shipped_sites() -> list[str]:
    """Return the names of the sites that come with the package."""
    files = sorted((share_directory() / 'config').glob('*.yaml'))
    return [path.stem for path in files if 'cameras' in read_yaml_file(path, ConfigError)]
